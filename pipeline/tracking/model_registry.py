"""Trained models in MLflow: logged, registered under names of their own, the best one promoted."""

import io
from contextlib import redirect_stderr
from importlib.metadata import version
from typing import Any

import mlflow
from mlflow.entities.model_registry import ModelVersion
from mlflow.exceptions import MlflowException
from mlflow.models import infer_signature

from rallygap.pipeline.tracking import served_model
from rallygap.pipeline.tracking.results import TrainedModel

CHAMPION, CHALLENGER = "champion", "challenger"
SCORE, DATA = "score", "data"  # tags of a version


def register_model(model: TrainedModel) -> None:
    """Log a model in the active run, as the newest version of its registered model."""
    loaded = served_model._load_pyfunc(str(model.folder))
    example = loaded.example()
    with redirect_stderr(io.StringIO()):  # MLflow has a line for every version
        logged: Any = mlflow.pyfunc.log_model(
            name=model.name,
            loader_module=served_model.__name__,
            data_path=str(model.folder),
            signature=infer_signature(example, loaded.predict(example)),
            input_example=example,
            pip_requirements=[f"rallygap[pipeline]=={version('rallygap')}"],
        )
        mlflow.log_metric(model.measure, model.score, model_id=logged.model_id)
        tags = {SCORE: repr(model.score), DATA: model.data}
        registered = mlflow.register_model(logged.model_uri, model.name, tags=tags)
    _promote(model, registered)


def _promote(model: TrainedModel, newest: ModelVersion) -> None:
    """Make the newest version the champion if it is better than the one, else the challenger.

    Scores compare on the same data only: on others the champion stays, until someone moves the
    alias by hand.
    """
    client = mlflow.MlflowClient()
    try:
        champion = client.get_model_version_by_alias(model.name, CHAMPION).tags
    except MlflowException as error:  # there is none, as after its deletion
        if error.error_code not in ("INVALID_PARAMETER_VALUE", "RESOURCE_DOES_NOT_EXIST"):
            raise
        alias = CHAMPION
    else:
        alias = CHALLENGER
        if model.data == champion.get(DATA):
            gain = model.score - float(champion[SCORE])
            if gain < 0 if model.smaller_is_better else gain > 0:
                client.delete_registered_model_alias(model.name, CHALLENGER)
                alias = CHAMPION
    # Stores differ in whether a version is a number or a text.
    client.set_registered_model_alias(model.name, alias, str(newest.version))
