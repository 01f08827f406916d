"""The stage: all trials of the study."""

import joblib
import pandas as pd
import pytest

import rallygap.stages.swap_study as run
from rallygap.pipeline.experiments.swap_study import trials
from rallygap.pipeline.policies.training import TrainingResult
from rallygap.pipeline.runtime.stage_run import StageRun
from rallygap.pipeline.transfer.retraining import in_simulator
from tests.pipeline.amendments import write_amended
from tests.pipeline.measured_shots import params, write_trained
from tests.pipeline.replayed import SETTINGS, replayed, write_replays
from tests.pipeline.trained_policies import chaser, description

CURVE = pd.DataFrame({"control_steps": [48], "hit_rate": [1.0], "return_rate": [0.5]})


def trained_policies(root, parameters, folder):
    """Policies that chase the ball, and the same in the amended simulator."""
    plain = [description(horizons=one) for one in ((115, 120, 125), (170, 175, 180))]
    amended = run.amended_simulator(root, parameters)
    again = [in_simulator(one, "arena", amended) for one in plain]
    return [TrainingResult(one, chaser(), CURVE, 1.0) for one in (*plain, *again)]


@pytest.fixture
def root(tmp_path, monkeypatch):
    """A repository with two shots of the arena to replay, and with policies that chase the ball."""
    shots = [replayed("arena/pro", number) for number in (4, 5)]
    artifacts = write_replays(tmp_path, shots, sources=("arena",))
    write_amended(artifacts / "close_gap", "arena", "imperfect_c", {"drag": {"cd": 0.54}})
    write_trained(tmp_path, "transformer")
    plain = params(sim2real=SETTINGS)
    few = plain.train_policy.model_copy(update={"trials": 2})
    used = plain.model_copy(update={"train_policy": few})
    monkeypatch.setattr(run, "profile_params", lambda root, name: used)
    monkeypatch.setattr(run, "trained_policies", trained_policies)
    monkeypatch.setattr(trials, "SETTINGS", trials.SETTINGS[:2])
    with joblib.parallel_config(backend="sequential"):
        yield tmp_path


def test_a_killed_run_resumes_and_publishes_all_tables(root, monkeypatch):
    played, trial = [], run.played

    def noted(one, columns):
        played.append(one)
        if len(played) == 4:
            raise KeyboardInterrupt
        return trial(one, columns)

    monkeypatch.setattr(run, "played", noted)
    with pytest.raises(KeyboardInterrupt):
        run.swap_study(StageRun("swap_study", root, None))
    left = list((root / "scratch").rglob("*.parquet"))
    assert len(left) == 3 and not (root / "reports").exists()
    run.swap_study(StageRun("swap_study", root, None))
    assert len(pd.read_csv(root / "reports/swap_study/policies.csv")) == 4
    names = {path.name for path in (root / "reports/swap_study").iterdir()}
    assert {"policies.csv", "readings.csv", "gains.csv"} <= names
