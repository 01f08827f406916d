"""The run: curves of all predictors on the same windows, with the record of the sample."""

import pandas as pd
import pytest

from rallygap.models.ball.simulators import shipped
from rallygap.pipeline.experiments.learning_curves import run
from rallygap.pipeline.experiments.learning_curves.subsets import Learner
from rallygap.pipeline.io.artifacts import read_json
from tests.models.predictors.small_training import BRIEF, TINY
from tests.pipeline.killed_runs import kill_at
from tests.pipeline.measured_shots import params, shot_tables, write_inputs

SPLITS = [*["train"] * 4, *["validation"] * 2]


@pytest.fixture
def root(tmp_path, monkeypatch):
    """A repository with few recordings, and with a tiny network that learns from them."""
    shots = [shot_tables("arena/club", k, split=split) for k, split in enumerate(SPLITS)]
    write_inputs(tmp_path, shots=shots)
    (tmp_path / "params.yaml").write_text("seed: 1")
    changes = {"sources": ["arena"], "networks": {"tiny": TINY}, "training": BRIEF}
    settings = params().train_predictor.model_copy(update=changes)
    monkeypatch.setenv("LOKY_MAX_CPU_COUNT", "1")
    monkeypatch.setattr(run, "load_params", lambda path: params(train_predictor=settings))
    monkeypatch.setattr(run, "SIZES", (2,))
    monkeypatch.setattr(run, "DRAWS", 2)
    monkeypatch.setattr(run, "NETWORKS", ("tiny",))
    return tmp_path


def test_a_killed_run_resumes_and_publishes_curves(root, monkeypatch):
    amended = []

    def amend(self, subset, name):
        amended.append(subset.name)
        return shipped(name)

    monkeypatch.setattr(Learner, "amended", amend)
    kill_at(run, "_trained", run.learning_curves, root)
    run.learning_curves(root)
    assert sorted(amended) == ["2-0", "2-1", "4-0", "4-1"]
    rows = pd.read_csv(root / "reports/learning_curves.csv")
    assert set(rows["predictor"]) == {"amended_imperfect_c", "tiny", "oracle"}
    assert set(rows["recordings"]) == {2, 4}
    record = read_json(root / "reports/learning_curves.json")
    assert record["draws"] == 2
    assert (root / "reports/learning_curves.png").exists()
    assert not list((root / "scratch").rglob("*.yaml"))
