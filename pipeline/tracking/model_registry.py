"""Trained predictors in MLflow: logged as models, registered, the best one promoted."""

import json
from pathlib import Path
from typing import Any

import mlflow.pyfunc
import numpy as np
from mlflow import MlflowClient
from mlflow.entities.model_registry import ModelVersion
from mlflow.exceptions import MlflowException
from mlflow.models import Model, infer_signature

from rallygap.pipeline.tracking.recording import Results

FOLDER = Path("artifacts/train_predictor")
CHAMPION = "champion"
LOSS, BALLS = "validation_loss", "validation_balls"  # tags of a version


def _example() -> dict[str, Any]:
    """One window: a ball that flies at 8 m/s towards the robot under gravity, with topspin."""
    times = 0.005 * np.arange(-11, 1)
    states = np.zeros((1, 12, 6))
    states[0, :, 1] = 1.0 - 8.0 * times
    states[0, :, 2] = 0.3 + 2.0 * times - 4.9 * times**2
    states[0, :, 3] = 100.0
    return {"states": states, "mask": np.ones((1, 12, 6), dtype=bool)}


EXAMPLE = _example()
SIGNATURE = infer_signature(
    EXAMPLE, {"states": np.zeros((1, 60, 9)), "spin_measured": np.ones(1, dtype=bool)}
)


def register_predictors(client: MlflowClient, run_id: str, results: Results) -> None:
    """Log and register every predictor that the stage left in the working directory.

    Args:
        client: of the store.
        run_id: of the stage's run.
        results: of the stage.
    """
    digests = {data.name: data.digest for data in results.inputs}
    for path in sorted(FOLDER.glob("*/predictor.json")):
        description = json.loads(path.read_text(encoding="utf-8"))
        epochs = results.metrics[description["name"]]
        loss = epochs[max(epochs, key=int)]["validation"]
        digest = digests["+".join(description["sources"])]
        _promote(client, _register(client, run_id, path.parent, description, loss, digest))


def _register(
    client: MlflowClient,
    run_id: str,
    folder: Path,
    description: dict[str, Any],
    loss: float,
    digest: str,
) -> ModelVersion:
    """Log a predictor as a model of its run, the newest version of its registered model.

    Args:
        client: of the store.
        run_id: of the stage's run.
        folder: with its weights.
        description: the content of its predictor.json.
        loss: on the validation windows after the last epoch; normalised, without unit.
        digest: of the table that the windows are cut from.
    """
    sources = "+".join(description["sources"])
    model = f"predictor-{sources}"  # one for all networks of the same sets
    logged = Model.log(
        None,
        mlflow.pyfunc,
        run_id=run_id,
        name=description["name"],
        model_type=description["network"]["kind"],
        registered_model_name=model,
        loader_module="rallygap.pipeline.tracking.served_predictor",
        data_path=str(folder),
        signature=SIGNATURE,
        input_example=EXAMPLE,
        pip_requirements=[],  # it loads where this repository is installed, and not elsewhere
    )
    measured = {"model_id": logged.model_id, "dataset_name": sources, "dataset_digest": digest}
    client.log_metric(run_id, LOSS, loss, **measured)
    version = str(logged.registered_model_version)
    for name, value in {"predictor": description["name"], LOSS: repr(loss), BALLS: digest}.items():
        client.set_model_version_tag(model, version, name, value)
    return client.get_model_version(model, version)


def _promote(client: MlflowClient, version: ModelVersion) -> None:
    """Give a version the alias `champion` if it is better than the one that has it.

    Losses compare on the same recordings only: on others the champion stays, until someone moves
    the alias by hand.
    """
    champion = current_champion(client, version.name)
    if champion is None or beats(version.tags, champion.tags):
        # Stores differ in whether a version is a number or a text.
        client.set_registered_model_alias(version.name, CHAMPION, str(version.version))


def current_champion(client: MlflowClient, name: str) -> ModelVersion | None:
    """The version with the alias, or None where there is none, as after its deletion."""
    try:
        return client.get_model_version_by_alias(name, CHAMPION)
    except MlflowException as error:
        if error.error_code not in ("INVALID_PARAMETER_VALUE", "RESOURCE_DOES_NOT_EXIST"):
            raise
        return None


def beats(challenger: dict[str, str], champion: dict[str, str]) -> bool:
    """Whether the challenger has the lower loss on the same recordings, by the tags of both."""
    same = challenger[BALLS] == champion.get(BALLS)
    return same and float(challenger[LOSS]) < float(champion[LOSS])
