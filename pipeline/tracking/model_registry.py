"""Trained predictors in MLflow: logged as models that predict again, registered, the best named.

Called by the recorder when ``train_predictor`` has ended. It reads what the stage left and never
loads a network, so it needs neither torch nor seconds.
"""

import json
import tempfile
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import mlflow.pyfunc
import numpy as np
from mlflow import MlflowClient
from mlflow.entities import LoggedModelOutput
from mlflow.entities.model_registry import ModelVersion
from mlflow.exceptions import MlflowException
from mlflow.models import Model, ModelSignature
from mlflow.types import Schema, TensorSpec

STAGE_OF_PREDICTORS = "train_predictor"
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
    """A predictor that the stage left.

    Attributes:
        folder: with its weights.
        name: under which reports list it.
        sources: sets of measured balls that it learned from, and was validated on.
        description: all that its weights belong to.
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


def register_predictors(client: MlflowClient, run_id: str, end: dict[str, Any]) -> None:
    """Log and register every predictor of the stage that ended in the working directory.

    Args:
        client: of the store.
        run_id: of the stage's run.
        end: what the stage left; see ``pipeline.runtime.stage_run.StageRun.results``.
    """
    for one in trained_predictors(Path("artifacts") / STAGE_OF_PREDICTORS, end):
        model_id = log_model(client, run_id, one)
        version = register(client, run_id, model_id, one)
        crown(client, version)


def trained_predictors(folder: Path, end: dict[str, Any]) -> Iterator[Trained]:
    """The predictors in a folder, each with its last validation loss."""
    digests = {item["name"]: item["digest"] for item in end["inputs"]}
    for path in sorted(folder.glob("*/predictor.json")):
        description = json.loads(path.read_text(encoding="utf-8"))
        name, sources = description["name"], "+".join(description["sources"])
        epochs = end["metrics"][name]
        loss = epochs[max(epochs, key=int)]["validation"]
        yield Trained(path.parent, name, sources, description, loss, digests[sources])


def log_model(client: MlflowClient, run_id: str, one: Trained) -> str:
    """Log a predictor as a model of its run, with signature and example; return the model's id."""
    experiment = client.get_run(run_id).info.experiment_id
    kind = one.description["network"]["kind"]
    logged = client.create_logged_model(experiment, one.name, run_id, model_type=kind)
    identity = Model(run_id=run_id, model_uuid=logged.model_id, model_id=logged.model_id)
    with tempfile.TemporaryDirectory() as scratch:
        saved = Path(scratch) / "model"
        mlflow.pyfunc.save_model(
            path=str(saved),
            loader_module="pipeline.tracking.served_predictor",
            data_path=str(one.folder),
            mlflow_model=identity,
            signature=SIGNATURE,
            input_example=example(),
            pip_requirements=[],  # it loads where this repository is installed, and not elsewhere
        )
        client.log_model_artifacts(logged.model_id, str(saved))
    client.finalize_logged_model(logged.model_id, "READY")
    client.log_outputs(run_id, [LoggedModelOutput(logged.model_id, 0)])
    client.log_metric(
        run_id,
        LOSS,
        one.loss,
        model_id=logged.model_id,
        dataset_name=one.sources,
        dataset_digest=one.balls,
    )
    return str(logged.model_id)


def register(client: MlflowClient, run_id: str, model_id: str, one: Trained) -> ModelVersion:
    """Make a logged model the newest version of its registered model."""
    try:
        client.create_registered_model(one.registered_name)
    except MlflowException as error:
        if error.error_code != "RESOURCE_ALREADY_EXISTS":
            raise
    return client.create_model_version(
        one.registered_name,
        f"models:/{model_id}",
        run_id,
        tags={"predictor": one.name, LOSS: repr(one.loss), BALLS: one.balls},
        model_id=model_id,
    )


def crown(client: MlflowClient, version: ModelVersion) -> None:
    """Give a version the alias `champion` if it is better than the one that has it.

    Losses compare on the same balls only: on others the champion stays, until someone moves the
    alias by hand.
    """
    champion = current_champion(client, version.name)
    if champion is None or beats(version.tags, champion.tags):
        # Stores differ in whether a version is a number or a text.
        client.set_registered_model_alias(version.name, CHAMPION, str(version.version))


def current_champion(client: MlflowClient, name: str) -> ModelVersion | None:
    """The version with the alias, or None where there is none, or it was deleted."""
    try:
        return client.get_model_version_by_alias(name, CHAMPION)
    except MlflowException as error:
        if error.error_code not in ("INVALID_PARAMETER_VALUE", "RESOURCE_DOES_NOT_EXIST"):
            raise
        return None


def beats(challenger: dict[str, str], champion: dict[str, str]) -> bool:
    """Whether the challenger has the lower loss on the same balls, by the tags of both."""
    same = challenger[BALLS] == champion.get(BALLS)
    return same and float(challenger[LOSS]) < float(champion[LOSS])


def example() -> dict[str, Any]:
    """One ball that flies at 8 m/s towards the robot under gravity, with topspin."""
    times = 0.005 * np.arange(-11, 1)
    states = np.zeros((1, 12, 6))
    states[0, :, 1] = 1.0 - 8.0 * times
    states[0, :, 2] = 0.3 + 2.0 * times - 4.9 * times**2
    states[0, :, 3] = 100.0
    return {"states": states, "mask": np.ones((1, 12, 6), dtype=bool)}
