"""The stage: curves of all predictors on the same windows."""

import pandas as pd
import pytest

import rallygap.stages.learning_curves as run
from rallygap.models.ball.simulators import shipped
from rallygap.pipeline.experiments.learning_curves.subsets import Learner
from rallygap.pipeline.runtime.stage_run import StageRun
from tests.models.predictors.small_training import BRIEF, TINY
from tests.pipeline.killed_runs import kill_at
from tests.pipeline.measured_shots import params, shot_tables, write_inputs

SPLITS = [*["train"] * 4, *["validation"] * 2]


@pytest.fixture
def stage(tmp_path, monkeypatch):
    """A run on few recordings, and with a tiny network that learns from them."""
    shots = [shot_tables("arena/club", k, split=split) for k, split in enumerate(SPLITS)]
    write_inputs(tmp_path, shots=shots)
    changes = {"sources": ["arena"], "networks": {"tiny": TINY}, "training": BRIEF}
    settings = params().train_predictor.model_copy(update=changes)
    monkeypatch.setenv("LOKY_MAX_CPU_COUNT", "1")
    monkeypatch.setattr(run, "SIZES", (2,))
    monkeypatch.setattr(run, "DRAWS", 2)
    monkeypatch.setattr(run, "NETWORKS", ("tiny",))
    return StageRun("learning_curves", tmp_path, params(train_predictor=settings))


def test_a_killed_run_resumes_and_publishes_curves(stage, monkeypatch):
    amended = []

    def amend(self, subset, name):
        amended.append(subset.name)
        return shipped(name)

    monkeypatch.setattr(Learner, "amended", amend)
    kill_at(run, "_trained", run.learning_curves, stage)
    run.learning_curves(stage)
    assert sorted(amended) == ["2-0", "2-1", "4-0", "4-1"]
    rows = pd.read_csv(stage.report("errors.csv"))
    assert set(rows["predictor"]) == {"amended_imperfect_c", "tiny", "oracle"}
    assert set(rows["recordings"]) == {2, 4}
    assert set(rows["draws"]) == {2}
