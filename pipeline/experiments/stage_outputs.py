"""The outputs of every stage, as dvc.yaml and dvc.lock list them."""

from pathlib import Path, PurePosixPath
from typing import Annotated, Any

from pydantic import AfterValidator, BaseModel, BeforeValidator, ValidationError

from pipeline.params import read_yaml
from pipeline.runtime.errors import InputError


def _path(output: Any) -> Any:
    """Return the path of an output: alone, noted beside its MD5, or the key of its settings."""
    if isinstance(output, dict) and output:
        return output.get("path", next(iter(output)))
    return output


def _inside(path: str) -> str:
    """Refuse what is not under the repository: who asks may search or remove it."""
    parts = PurePosixPath(path).parts
    if not parts or ".." in parts or path.startswith("/"):
        raise ValueError("is no path under the repository")
    return path


class _Stage(BaseModel):
    outs: list[Annotated[str, BeforeValidator(_path), AfterValidator(_inside)]] = []


class _Stages(BaseModel):
    stages: dict[str, _Stage]


def stage_outputs(path: Path) -> dict[str, list[str]]:
    """Return stage to the paths of its outputs, relative to the repository.

    Args:
        path: of dvc.yaml or dvc.lock.

    Raises:
        InputError: the file is missing or lists no such outputs.
    """
    try:
        listed = _Stages.model_validate(read_yaml(path))
    except ValidationError as error:
        first = error.errors()[0]
        place = ".".join(map(str, first["loc"]))
        problem = f"{first['msg']}; `git checkout {path.name}` takes it back"
        raise InputError(path, problem, field=place) from None
    return {name: stage.outs for name, stage in listed.stages.items()}
