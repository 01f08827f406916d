"""Trained predictors in MLflow load and predict again, and the best one is the champion."""

import subprocess
import sys
from pathlib import Path

import mlflow
import numpy as np
import pytest
import torch

from rallygap.models.predictors.learned import build_network
from rallygap.models.predictors.settings import TrainingSettings, TransformerSettings
from rallygap.models.predictors.spread import Spread
from rallygap.pipeline.predictors.storage import Learning, TrainedPredictor, save_predictor
from rallygap.pipeline.runtime.provenance import Provenance
from rallygap.pipeline.tracking.model_registry import EXAMPLE, beats, register_predictors
from rallygap.pipeline.tracking.recording import InputData, Results, recorded

ROOT = Path(__file__).parents[3]
NETWORK = TransformerSettings(
    kind="transformer", width=8, expanded=8, heads=2, encoder_layers=1, decoder_layers=1,
    states_per_row=10, uniform_motion=True,
)  # fmt: skip
TRAINING = TrainingSettings(
    epochs=2, windows_per_episode=1, batch=1, learning_rate=0.1, matrix_learning_rate=None,
    decay=None, max_gradient_norm=None, hidden_spin=0, precision="32-true", threads=1,
)  # fmt: skip
LEARNING = Learning(episodes=1, windows=1, validation_episodes=1, settings=TRAINING, seed=0)

PREDICT_AGAIN = """
import sys, mlflow, numpy as np
mlflow.set_tracking_uri(sys.argv[1])
model = mlflow.pyfunc.load_model("models:/predictor-arena@champion")
forecast = model.predict(model.input_example)
np.savez(sys.argv[2], signature=str(model.metadata.signature), **forecast)
"""


def trained(folder, seed):
    """An untrained network, written as the stage writes a trained one."""
    torch.manual_seed(seed)
    network = build_network(NETWORK)
    description = TrainedPredictor(
        name="small", network=NETWORK, parameters=network.parameter_count, sources=["arena"],
        starts_from=None, learning=LEARNING,
    )  # fmt: skip
    save_predictor(folder / "artifacts/train_predictor/small", network, Spread(), description)


def register(client, folder, loss, balls):
    """Register what lies in the folder, as the end of a stage with this loss on these balls."""
    run = client.create_run("0", tags={"rallygap.fingerprint": f"{balls}{loss}"})
    epochs = {"9": {"validation": 8.0}, "10": {"validation": loss}}
    data = InputData("arena", "samples.parquet", 1, balls)
    register_predictors(client, run.info.run_id, Results({"small": epochs}, [data]))


@pytest.fixture(scope="module")
def store(tmp_path_factory):
    """A store with versions of losses 3 and 2 on the same balls, 4 on them, and 1 on others."""
    folder = tmp_path_factory.mktemp("store")
    uri = f"sqlite:///{folder / 'mlflow.db'}"
    with pytest.MonkeyPatch.context() as patch:
        patch.chdir(folder)
        mlflow.set_tracking_uri(uri)
        mlflow.set_experiment(experiment_id="0")  # other tests leave theirs
        client = mlflow.MlflowClient(uri)
        for seed, (loss, balls) in enumerate([(3.0, "a"), (2.0, "a"), (4.0, "a"), (1.0, "b")]):
            trained(folder, seed)
            register(client, folder, loss, balls)
        yield client, uri, folder
        mlflow.set_tracking_uri(None)


def test_the_champion_has_the_lowest_loss_on_its_balls(store):
    champion = store[0].get_model_version_by_alias("predictor-arena", "champion")
    assert str(champion.version) == "2"
    assert float(champion.tags["validation_loss"]) == 2.0


def test_a_model_predicts_the_same_in_a_fresh_process(store, tmp_path):
    _, uri, _ = store
    command = [sys.executable, "-c", PREDICT_AGAIN, uri, str(tmp_path / "out.npz")]
    subprocess.run(command, cwd=ROOT, check=True, capture_output=True)
    again = np.load(tmp_path / "out.npz")
    torch.manual_seed(1)  # of the champion
    states = torch.tensor(EXAMPLE["states"], dtype=torch.float32)
    seen = torch.tensor(EXAMPLE["mask"])
    with torch.inference_mode():
        expected = build_network(NETWORK).eval()(states, seen).numpy()
    # The last bits follow the number of threads.
    np.testing.assert_allclose(again["states"], expected, rtol=1e-4, atol=1e-4)
    assert again["spin_measured"].tolist() == [True]
    assert "'states'" in str(again["signature"]) and "'mask'" in str(again["signature"])


def test_a_stage_logs_its_predictors_in_the_experiment_of_its_run(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    monkeypatch.setenv("DVC_ROOT", str(tmp_path))
    monkeypatch.delenv("MLFLOW_TRACKING_URI", raising=False)
    trained(tmp_path, 0)
    results = Results(
        {"small": {"10": {"validation": 2.0}}}, [InputData("arena", "samples.parquet", 1, "a")]
    )
    with recorded("train_predictor", Provenance("train", "f" * 64), {}, lambda: results):
        pass
    client = mlflow.MlflowClient(f"sqlite:///{tmp_path / 'mlflow.db'}")
    experiment = client.get_experiment_by_name("rallygap").experiment_id
    assert len(client.search_logged_models([experiment])) == 1
    assert not (tmp_path / "mlruns").exists()


def test_nothing_in_a_logged_model_is_pickled(store):
    files = {path.name for path in store[2].rglob("mlruns/**/artifacts/**/*") if path.is_file()}
    assert "weights.safetensors" in files
    assert not {name for name in files if name.endswith((".pkl", ".pickle", ".pt", ".pth"))}


def test_other_balls_do_not_compare():
    champion = {"validation_loss": "2.0", "validation_balls": "a"}
    assert beats({"validation_loss": "1.5", "validation_balls": "a"}, champion)
    assert not beats({"validation_loss": "1.5", "validation_balls": "b"}, champion)
