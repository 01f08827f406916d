"""Trained predictors in MLflow: logged as models, registered, the best one promoted."""

import json
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import mlflow.pyfunc
import numpy as np
from mlflow import MlflowClient
from mlflow.entities.model_registry import ModelVersion
from mlflow.exceptions import MlflowException
from mlflow.models import Model, ModelSignature
from mlflow.types import Schema, TensorSpec

from pipeline.tracking.recording import Results

FOLDER = Path("artifacts/train_predictor")
CHAMPION = "champion"
LOSS, BALLS = "validation_loss", "validation_balls"  # tags of a version

STATES, MASK = (-1, 12, 6), (-1, 12, 6)
SIGNATURE = ModelSignature(
    inputs=Schema(
        [
            TensorSpec(np.dtype(np.float64), STATES, "states"),
            TensorSpec(np.dtype(np.bool_), MASK, "mask"),
        ]
    ),
    outputs=Schema(
        [
            TensorSpec(np.dtype(np.float64), (-1, 60, 9), "states"),
            TensorSpec(np.dtype(np.bool_), (-1,), "spin_measured"),
        ]
    ),
)


@dataclass(frozen=True)
class Trained:
    """A predictor that the stage trained.

    Attributes:
        folder: with its weights.
        name: in the reports.
        sources: data sets that it was trained and validated on.
        description: the content of its predictor.json.
        loss: on the validation windows after the last epoch; normalised, without unit.
        balls: digest of the table that the windows are cut from.
    """

    folder: Path
    name: str
    sources: str
    description: dict[str, Any]
    loss: float
    balls: str

    @property
    def registered_name(self) -> str:
        """The registered model that it is a version of: one for all networks of the same sets."""
        return f"predictor-{self.sources}"


def register_predictors(client: MlflowClient, run_id: str, results: Results) -> None:
    """Log and register every predictor that the stage left in the working directory.

    Args:
        client: of the store.
        run_id: of the stage's run.
        results: of the stage.
    """
    for predictor in trained_predictors(FOLDER, results):
        promote(client, register(client, run_id, predictor))


def trained_predictors(folder: Path, results: Results) -> Iterator[Trained]:
    """The predictors in a folder, each with its last validation loss."""
    digests = {data.name: data.digest for data in results.inputs}
    for path in sorted(folder.glob("*/predictor.json")):
        description = json.loads(path.read_text(encoding="utf-8"))
        name, sources = description["name"], "+".join(description["sources"])
        epochs = results.metrics[name]
        loss = epochs[max(epochs, key=int)]["validation"]
        yield Trained(path.parent, name, sources, description, loss, digests[sources])


def register(client: MlflowClient, run_id: str, predictor: Trained) -> ModelVersion:
    """Log a predictor as a model of its run, the newest version of its registered model."""
    logged = Model.log(
        None,
        mlflow.pyfunc,
        run_id=run_id,
        name=predictor.name,
        model_type=predictor.description["network"]["kind"],
        registered_model_name=predictor.registered_name,
        loader_module="pipeline.tracking.served_predictor",
        data_path=str(predictor.folder),
        signature=SIGNATURE,
        input_example=example(),
        pip_requirements=[],  # it loads where this repository is installed, and not elsewhere
    )
    client.log_metric(
        run_id,
        LOSS,
        predictor.loss,
        model_id=logged.model_id,
        dataset_name=predictor.sources,
        dataset_digest=predictor.balls,
    )
    version = str(logged.registered_model_version)
    tags = {"predictor": predictor.name, LOSS: repr(predictor.loss), BALLS: predictor.balls}
    for name, value in tags.items():
        client.set_model_version_tag(predictor.registered_name, version, name, value)
    return client.get_model_version(predictor.registered_name, version)


def promote(client: MlflowClient, version: ModelVersion) -> None:
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


def example() -> dict[str, Any]:
    """One window: a ball that flies at 8 m/s towards the robot under gravity, with topspin."""
    times = 0.005 * np.arange(-11, 1)
    states = np.zeros((1, 12, 6))
    states[0, :, 1] = 1.0 - 8.0 * times
    states[0, :, 2] = 0.3 + 2.0 * times - 4.9 * times**2
    states[0, :, 3] = 100.0
    return {"states": states, "mask": np.ones((1, 12, 6), dtype=bool)}
