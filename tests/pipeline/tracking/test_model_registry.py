"""Trained models in MLflow load and predict again, and the best one is the champion."""

import shutil
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
from rallygap.pipeline.tracking.model_registry import register_model
from rallygap.pipeline.tracking.recording import recorded
from rallygap.pipeline.tracking.results import Results, TrainedModel
from rallygap.pipeline.tracking.served_model import ServedPredictor
from tests.pipeline.trained_policies import save_drawn

NETWORK = TransformerSettings(
    kind="transformer", width=8, expanded=8, heads=2, encoder_layers=1, decoder_layers=1,
    states_per_row=10, uniform_motion=True,
)  # fmt: skip
TRAINING = TrainingSettings(
    epochs=2, windows_per_episode=1, batch=1, learning_rate=0.1, matrix_learning_rate=None,
    decay=None, max_gradient_norm=None, hidden_spin=0, precision="32-true", threads=1,
)  # fmt: skip
LEARNING = Learning(episodes=1, windows=1, validation_episodes=1, settings=TRAINING, seed=0)


def trained(folder, seed):
    """An untrained network, written as the stage writes a trained one."""
    torch.manual_seed(seed)
    network = build_network(NETWORK)
    description = TrainedPredictor(
        name="small", network=NETWORK, parameters=network.parameter_count, sources=["arena"],
        starts_from=None, learning=LEARNING,
    )  # fmt: skip
    save_predictor(folder / "small", network, Spread(), description)
    return folder / "small"


def predictor(folder, loss, balls):
    return TrainedModel("predictor-small-arena", folder, "validation_loss", loss, True, balls)


@pytest.fixture(scope="module")
def store(tmp_path_factory, empty_store):
    """A store with versions of losses 3 and 2 on the same balls, and 1 on others."""
    folder = tmp_path_factory.mktemp("store")
    uri = f"sqlite:///{shutil.copy(empty_store, folder)}"
    mlflow.set_tracking_uri(uri)
    mlflow.create_experiment("models", artifact_location=(folder / "mlruns").as_uri())
    mlflow.set_experiment("models")
    with mlflow.start_run():
        for seed, (loss, balls) in enumerate([(3.0, "a"), (2.0, "a"), (1.0, "b")]):
            register_model(predictor(trained(folder, seed), loss, balls))
    yield mlflow.MlflowClient(uri), uri, folder
    mlflow.set_tracking_uri(None)


def version_of(client, alias, name="predictor-small-arena"):
    return str(client.get_model_version_by_alias(name, alias).version)


def test_the_champion_has_the_lowest_loss_on_its_balls_and_the_newest_challenges_it(store):
    assert version_of(store[0], "champion") == "2"
    assert version_of(store[0], "challenger") == "3"


def test_a_model_predicts_the_same_again_and_nothing_in_it_is_pickled(store):
    mlflow.set_tracking_uri(store[1])
    model = mlflow.pyfunc.load_model("models:/predictor-small-arena@champion")
    again = model.predict(model.input_example)
    torch.manual_seed(1)  # of the champion
    network = build_network(NETWORK).eval()
    example = ServedPredictor(None).example()
    states = torch.tensor(example["states"], dtype=torch.float32)
    with torch.inference_mode():
        expected = network(states, torch.tensor(example["mask"])).numpy()
    # The last bits follow the number of threads.
    np.testing.assert_allclose(again["states"], expected, rtol=1e-4, atol=1e-4)
    assert again["spin_measured"].tolist() == [True]
    assert {"states", "mask"} <= set(model.metadata.signature.inputs.input_names())
    files = {path.name for path in store[2].rglob("mlruns/**/artifacts/**/*") if path.is_file()}
    assert "weights.safetensors" in files
    assert not {name for name in files if name.endswith((".pkl", ".pickle", ".pt", ".pth"))}


def test_a_stage_registers_its_policies_without_a_word(tmp_path, monkeypatch, capfd, empty_store):
    shutil.copy(empty_store, tmp_path)
    monkeypatch.chdir(tmp_path)
    monkeypatch.setenv("DVC_ROOT", str(tmp_path))
    monkeypatch.delenv("MLFLOW_TRACKING_URI", raising=False)
    policy, described = save_drawn(tmp_path)
    name = f"policy-{described.name}"
    models = [
        TrainedModel(name, tmp_path / described.name, "return_rate", rate, False, "shots")
        for rate in (0.7, 0.5)
    ]
    with recorded(
        "train_policy", Provenance("train", "f" * 64), {}, lambda: Results({}, models=models)
    ):
        pass
    assert capfd.readouterr() == ("", "")
    assert version_of(mlflow.MlflowClient(), "champion", name) == "1"
    model = mlflow.pyfunc.load_model(f"models:/{name}@champion")
    seen = model.input_example
    np.testing.assert_array_equal(model.predict(seen)["actions"], policy.act(seen["observations"]))
    listed = mlflow.pyfunc.get_model_dependencies(f"models:/{name}@champion")
    assert "rallygap[pipeline]==" in Path(listed).read_text()
    assert not (tmp_path / "mlruns").exists()
