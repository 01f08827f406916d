"""The stages of dvc.yaml: what each reads and writes."""

from pathlib import Path
from typing import Annotated, Any

from pydantic import BaseModel, BeforeValidator, ValidationError

from rallygap.pipeline.params import read_yaml
from rallygap.pipeline.runtime.errors import InputError


def _path(output: Any) -> Any:
    """The path of an output: alone, or the key of its settings."""
    return next(iter(output)) if isinstance(output, dict) and output else output


class DvcStage(BaseModel):
    """A stage: paths relative to the repository."""

    deps: list[Path] = []
    outs: list[Annotated[Path, BeforeValidator(_path)]] = []


class _Pipeline(BaseModel):
    stages: dict[str, DvcStage]


def dvc_stages(path: Path) -> dict[str, DvcStage]:
    """Return the stages of a dvc.yaml by name.

    Raises:
        InputError: the file is missing or lists no such stages.
    """
    try:
        return _Pipeline.model_validate(read_yaml(path)).stages
    except ValidationError as error:
        first = error.errors()[0]
        place = ".".join(map(str, first["loc"]))
        problem = f"{first['msg']}; `git checkout {path.name}` restores it"
        raise InputError(path, problem, field=place) from None


def upstream(stages: dict[str, DvcStage], name: str) -> set[str]:
    """The stages that a stage depends on, directly or not."""
    reads = stages[name].deps
    direct = {
        other
        for other, stage in stages.items()
        for out in stage.outs
        if any(path == out or path in out.parents or out in path.parents for path in reads)
    } - {name}
    return direct.union(*(upstream(stages, other) for other in direct))
