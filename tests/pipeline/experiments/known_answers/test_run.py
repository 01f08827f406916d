"""A run asks every question once, resumes, and leaves a table and scores."""

import json

import joblib
import pandas as pd
import pytest

import rallygap.stages.known_answers
from rallygap.models.ball.simulators import shipped
from rallygap.models.gap.hypotheses import Hypothesis, hypotheses
from rallygap.pipeline.experiments.known_answers import answers
from rallygap.pipeline.experiments.known_answers.answers import IDENTITIES, Diagnosis, verdicts
from rallygap.pipeline.experiments.known_answers.design import (
    IN_RECORDINGS,
    IN_SIMULATOR,
    PlantedError,
    plant,
)
from rallygap.pipeline.gap.measured_shots import read_shots
from rallygap.pipeline.runtime.errors import InputError
from rallygap.pipeline.runtime.stage_run import StageRun
from tests.pipeline.experiments.known_answers.made_up import cause, found, shots
from tests.pipeline.recorded import write_recordings

NOMINAL = shipped("literature")
SIMULATOR_QUESTIONS = 3 * len(IN_SIMULATOR)
LIMITS = dict.fromkeys([*IN_SIMULATOR, *IN_RECORDINGS], 0.01)


class Expert:
    """Knows the physics, which is ``literature``; sees no error of recordings."""

    def __init__(self, killed_after=10_000):
        self.calls, self.killed_after = 0, killed_after

    def __call__(self, shots, simulator):
        if self.calls == self.killed_after:
            raise KeyboardInterrupt
        self.calls += 1
        wrong = [one for one in hypotheses(simulator) if one.value(simulator) != one.value(NOMINAL)]
        causes = (self._cause(one, simulator) for one in wrong)
        return found(*causes).model_copy(update={"minimum_detectable": LIMITS})

    @staticmethod
    def reference_values(shots, simulator):
        return {
            identity: Hypothesis.from_identity(identity).value(NOMINAL) for identity in IDENTITIES
        }

    def _cause(self, one: Hypothesis, simulator):
        return cause(one.identity, one.value(NOMINAL), one.value(simulator), margin=1e-4)


@pytest.fixture
def expert(monkeypatch):
    def employ(**settings):
        made = Expert(**settings)
        monkeypatch.setattr(answers, "diagnose", made)
        monkeypatch.setattr(answers, "reference_values", made.reference_values)
        return made

    return employ


@pytest.fixture
def root(tmp_path, monkeypatch):
    """A folder for the run, and another with one measured set."""
    write_recordings(tmp_path / "sets" / "csv", shots=8)
    monkeypatch.setenv("RALLYGAP_DATA", str(tmp_path / "sets"))
    monkeypatch.setattr(rallygap.stages.known_answers, "SETS", ["csv"])
    return tmp_path


def run(root):
    stage = StageRun("known_answers", root, None)
    with joblib.parallel_config(backend="sequential"):
        rallygap.stages.known_answers.known_answers(stage)
    return json.loads(stage.report("scores.json").read_text())


def test_the_run_leaves_a_table_and_scores(root, expert):
    expert()
    (scores,) = run(root).values()
    assert scores["leading"] == scores["exact"] == 2 * SIMULATOR_QUESTIONS
    assert scores["coverage"] == 1.0
    assert scores["false_causes"] == 0
    assert (scores["unplanted"], scores["unplanted_clean"]) == (2, 2)
    assert (scores["distorted"], scores["distorted_clean"]) == (6, 6)
    table = pd.read_csv(root / "reports" / "known_answers" / "answers.csv")
    assert len(table) == scores["questions"] + scores["unplanted"] + scores["distorted"]
    rows = table[table["leading"].notna()]
    assert (rows["leading"].astype(bool) == (rows["place"] == "simulator")).all()


def test_a_killed_run_resumes(root, expert, tmp_path_factory):
    expert(killed_after=10)
    with pytest.raises(KeyboardInterrupt):
        run(root)
    again = expert()
    resumed = run(root)
    whole = expert()
    assert run(tmp_path_factory.mktemp("whole")) == resumed
    assert again.calls == whole.calls - 10


def test_too_few_shots_are_refused_before_anything_is_diagnosed(root, expert, monkeypatch):
    employed = expert()
    monkeypatch.setattr(rallygap.stages.known_answers, "FOLDS", 3)
    with pytest.raises(InputError, match="csv: has a fold of fewer than 3 shots"):
        run(root)
    assert employed.calls == 0


def test_a_damaged_file_of_a_killed_run_is_named(tmp_path, expert):
    expert()
    diagnosis = Diagnosis(tmp_path / "0.base.json", shots(), NOMINAL)
    diagnosis.file.write_text("{}")
    with pytest.raises(InputError, match=r"0\.base\.json: is no verdict; remove it"):
        verdicts([diagnosis], "")


def test_a_planted_error_is_found_by_the_gap_workflow(tmp_path):
    write_recordings(tmp_path / "lab", shots=36)
    error = PlantedError("recordings", "position_scale.s", "medium", 0.02)
    lab = read_shots(tmp_path / "lab", "csv").shots
    simulator, planted = plant(error, NOMINAL, lab, {}, seed=0)
    diagnosis = Diagnosis(tmp_path / "0.json", planted, simulator)
    with joblib.parallel_config(backend="sequential"):
        (verdict,) = verdicts([diagnosis], "")
    assert verdict.main_causes[0].identity == "position_scale.s"
    assert verdict.main_causes[0].estimate == pytest.approx(0.02, rel=0.2)
