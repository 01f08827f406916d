"""Trained models in MLflow load and predict again, and the best one is the champion."""

import shutil
from pathlib import Path

import mlflow
import numpy as np
import pytest
import torch

from rallygap.pipeline.runtime.provenance import Provenance
from rallygap.pipeline.tracking.model_registry import register_model
from rallygap.pipeline.tracking.results import Results, TrainedModel
from rallygap.pipeline.tracking.runs import tracked_stage
from rallygap.pipeline.tracking.served_model import ServedPredictor
from tests.models.predictors.small_training import network
from tests.pipeline.measured_shots import write_trained
from tests.pipeline.trained_policies import save_drawn


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
            register_model(predictor(write_trained(folder, "small", seed), loss, balls))
    yield mlflow.MlflowClient(uri), uri, folder
    mlflow.set_tracking_uri(None)


def version_of(client, alias, name="predictor-small-arena"):
    return str(client.get_model_version_by_alias(name, alias).version)


def test_the_best_model_on_its_balls_predicts_the_same_again_and_nothing_is_pickled(store):
    versions = [version_of(store[0], alias) for alias in ("champion", "challenger")]
    assert versions == ["2", "3"]
    mlflow.set_tracking_uri(store[1])
    model = mlflow.pyfunc.load_model("models:/predictor-small-arena@champion")
    again = model.predict(model.input_example)
    champion = network(seed=1).eval()
    example = ServedPredictor(None).example()
    states = torch.tensor(example["states"], dtype=torch.float32)
    with torch.inference_mode():
        expected = champion(states, torch.tensor(example["mask"])).numpy()
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
    origin = Provenance("train", "f" * 64)
    with tracked_stage("train_policy", origin, {}, lambda: Results({}, models=models)):
        pass
    assert capfd.readouterr() == ("", "")
    assert version_of(mlflow.MlflowClient(), "champion", name) == "1"
    model = mlflow.pyfunc.load_model(f"models:/{name}@champion")
    seen = model.input_example
    np.testing.assert_array_equal(model.predict(seen)["actions"], policy.act(seen["observations"]))
    listed = mlflow.pyfunc.get_model_dependencies(f"models:/{name}@champion")
    assert "rallygap[pipeline]==" in Path(listed).read_text()
    assert not (tmp_path / "mlruns").exists()
