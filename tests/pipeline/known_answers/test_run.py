"""A run asks every question once, resumes, and leaves a table and scores."""

import json
from dataclasses import replace

import joblib
import pandas as pd
import pytest

from rallygap.models.ball.simulators import shipped
from rallygap.models.gap.hypotheses import Hypothesis, hypotheses
from rallygap.pipeline.known_answers import answers, references
from rallygap.pipeline.known_answers.answers import Diagnosis, fingerprint, verdicts
from rallygap.pipeline.known_answers.design import IN_RECORDINGS, IN_SIMULATOR, PlantedError
from rallygap.pipeline.known_answers.references import IDENTITIES
from rallygap.pipeline.known_answers.run import REPORT, SCORES, TABLE, run_known_answers
from rallygap.pipeline.runtime.errors import InputError
from tests.pipeline.known_answers.made_up import cause, found, shots
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
        monkeypatch.setattr(references, "reference_values", made.reference_values)
        return made

    return employ


@pytest.fixture
def root(tmp_path):
    """A repository with one file of each dependency, and a folder with one measured set."""
    for name in answers.DEPENDENCIES:
        path = tmp_path / name if "." in name else tmp_path / name / "a.py"
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_text("a = 1\n")
    write_recordings(tmp_path / "sets" / "csv", shots=8)
    return tmp_path


def run(root, folds=2):
    with joblib.parallel_config(backend="sequential"):
        return run_known_answers(root, root / "sets", ["csv"], folds)


def test_the_run_leaves_a_table_and_scores(root, expert):
    expert()
    (scores,) = run(root).values()
    assert json.loads((root / REPORT / SCORES).read_text()) == {"csv": scores}
    assert scores["leading"] == scores["exact"] == 2 * SIMULATOR_QUESTIONS
    assert scores["coverage"] == 1.0
    assert scores["false_causes"] == 0
    assert (scores["unplanted"], scores["unplanted_clean"]) == (2, 2)
    assert (scores["distorted"], scores["distorted_clean"]) == (6, 6)
    table = pd.read_csv(root / REPORT / TABLE)
    assert len(table) == scores["questions"] + scores["unplanted"] + scores["distorted"]
    rows = table[table["leading"].notna()]
    assert (rows["leading"].astype(bool) == (rows["place"] == "simulator")).all()
    assert not list((root / "scratch").rglob("*.json"))


def test_a_killed_run_resumes(root, expert):
    expert(killed_after=10)
    with pytest.raises(KeyboardInterrupt):
        run(root)
    again = expert()
    resumed = run(root)
    whole = expert()
    assert run(root) == resumed
    assert again.calls == whole.calls - 10


def test_a_run_does_not_resume_on_other_code(root, expert):
    expert(killed_after=10)
    with pytest.raises(KeyboardInterrupt):
        run(root)
    left = list((root / "scratch").rglob("*.json"))
    (root / "models/gap/a.py").write_text("a = 2\n")
    again = expert()
    run(root)
    assert left and list((root / "scratch").rglob("*.json")) == left
    whole = expert()
    run(root)
    assert again.calls == whole.calls


def test_the_fingerprint_follows_shots_and_folds(root):
    before = fingerprint(root, shots(), 3)
    assert fingerprint(root, shots(), 3) == before
    assert fingerprint(root, shots(), 4) != before
    moved = replace(shots(), positions=shots().positions + 1e-9)
    assert fingerprint(root, moved, 3) != before
    renamed = replace(shots(), groups=shots().groups[::-1])
    assert fingerprint(root, renamed, 3) != before


def test_too_few_shots_are_refused_before_anything_is_diagnosed(root, expert):
    employed = expert()
    with pytest.raises(InputError, match="csv: has a fold of fewer than 3 shots"):
        run(root, folds=3)
    assert employed.calls == 0


def test_a_damaged_file_of_a_killed_run_is_named(tmp_path, expert):
    expert()
    diagnosis = Diagnosis(tmp_path / "0.base.json", shots(), NOMINAL)
    diagnosis.file.write_text("{}")
    with pytest.raises(InputError, match=r"0\.base\.json: is no verdict; remove it"):
        verdicts([diagnosis], "")


def test_a_planted_error_is_found_by_the_gap_workflow(tmp_path):
    from rallygap.pipeline.gap.measured_shots import read_shots

    write_recordings(tmp_path / "lab", shots=36)
    error = PlantedError("recordings", "position_scale.s", "medium", 0.02)
    lab = read_shots(tmp_path / "lab", "csv").shots
    diagnosis = Diagnosis(tmp_path / "0.json", lab, NOMINAL, error)
    with joblib.parallel_config(backend="sequential"):
        (verdict,) = verdicts([diagnosis], "")
    assert verdict.main_causes[0].identity == "position_scale.s"
    assert verdict.main_causes[0].estimate == pytest.approx(0.02, rel=0.2)
