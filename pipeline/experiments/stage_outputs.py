"""The outputs of every stage, as dvc.yaml lists them."""

from pathlib import Path
from typing import Annotated, Any

from pydantic import BaseModel, BeforeValidator, ValidationError

from pipeline.params import read_yaml
from pipeline.runtime.errors import InputError


def _path(output: Any) -> Any:
    """The path of an output: alone, or the key of its settings."""
    return next(iter(output)) if isinstance(output, dict) and output else output


class _Stage(BaseModel):
    outs: list[Annotated[str, BeforeValidator(_path)]] = []


class _Stages(BaseModel):
    stages: dict[str, _Stage]


def stage_outputs(path: Path) -> dict[str, list[str]]:
    """Return stage to the paths of its outputs, relative to the repository.

    Args:
        path: of dvc.yaml.

    Raises:
        InputError: the file is missing or lists no such outputs.
    """
    try:
        listed = _Stages.model_validate(read_yaml(path))
    except ValidationError as error:
        first = error.errors()[0]
        place = ".".join(map(str, first["loc"]))
        problem = f"{first['msg']}; `git checkout {path.name}` restores it"
        raise InputError(path, problem, field=place) from None
    return {name: stage.outs for name, stage in listed.stages.items()}
