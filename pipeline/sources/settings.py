"""The settings of ingest: which sources to read, and from where."""

from pathlib import Path
from typing import Annotated

from pydantic import BaseModel, ConfigDict, Field, StringConstraints, field_validator

from models.arena.settings import ArenaSettings

# A name of a source is also a key of metrics, a folder and the first part of recording ids.
SourceName = Annotated[str, StringConstraints(pattern=r"^[a-z][a-z0-9_]*$", max_length=40)]


class IngestSettings(BaseModel):
    """Which sources to read, and from where."""

    model_config = ConfigDict(extra="forbid", frozen=True, allow_inf_nan=False)

    folder: Path | None
    """The folder that holds one folder a source (``spindoe/``, ``tt3d/``, ...); ``None`` leaves it
    to the environment variable ``RALLYGAP_DATA``."""
    sources: Annotated[list[SourceName], Field(min_length=1)]
    arena: ArenaSettings

    @field_validator("sources")
    @classmethod
    def _named_once(cls, sources: list[str]) -> list[str]:
        if len(set(sources)) < len(sources):
            raise ValueError("a source is named twice")
        return sources
