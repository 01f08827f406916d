"""The run: all trials of the study, with the record of the sample."""

import joblib
import pandas as pd
import pytest

from rallygap.pipeline.experiments.swap_study import run, trials
from rallygap.pipeline.io.artifacts import read_json
from rallygap.pipeline.policies.training import TrainingResult
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
    for name in ("params.yaml", run.PROFILE):
        (tmp_path / name).parent.mkdir(exist_ok=True)
        (tmp_path / name).write_text("seed: 1")
    plain = params(sim2real=SETTINGS)
    few = plain.train_policy.model_copy(update={"trials": 2})
    used = plain.model_copy(update={"train_policy": few})
    monkeypatch.setattr(run, "check_params", lambda values, root: used)
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
        run.swap_study(root)
    left = list((root / "scratch").rglob("*.parquet"))
    assert len(left) == 3 and not (root / "reports").exists()
    run.swap_study(root)
    record = read_json(root / "reports/swap_study/run.json")
    assert record["policies"] == 4
    names = {path.name for path in (root / "reports/swap_study").iterdir()}
    assert {"policies.csv", "readings.csv", "gains.csv", "readings.png", "mechanism.png"} <= names
    assert not list((root / "scratch").rglob("*.parquet"))
