"""The settings of ingest: which sources to read, and from where."""

from pathlib import Path
from typing import Annotated

from pydantic import BaseModel, ConfigDict, Field, StringConstraints, field_validator

# A name of a source is also a key of metrics, a folder and the first part of recording ids.
SourceName = Annotated[str, StringConstraints(pattern=r"^[a-z][a-z0-9_]*$", max_length=40)]
Share = Annotated[float, Field(ge=0, lt=1)]


class SyntheticCannonSettings(BaseModel):
    """A cannon session that is simulated, for a machine without measured balls."""

    model_config = ConfigDict(extra="forbid", frozen=True, allow_inf_nan=False)

    simulator: Annotated[str, StringConstraints(min_length=1)]
    """The name of a shipped simulator."""
    shots: Annotated[int, Field(ge=1, le=10_000)]
    rate_hz: Annotated[float, Field(ge=50, le=1000)]
    position_noise: Annotated[float, Field(ge=0, le=0.1)]
    """Standard deviation of a measured coordinate (m)."""
    spin_noise: Share
    """Standard deviation of a measured spin component, as a share of the spin."""
    dropouts: Share
    """Share of the samples that the cameras miss."""
    outliers: Share
    """Share of the samples where the cameras see something else."""


class IngestSettings(BaseModel):
    """Which sources to read, and from where."""

    model_config = ConfigDict(extra="forbid", frozen=True, allow_inf_nan=False)

    folder: Path | None
    """The folder that holds one folder a source (``spindoe/``, ``tt3d/``, ...); ``None`` leaves it
    to the environment variable ``RALLYGAP_DATA``."""
    sources: Annotated[list[SourceName], Field(min_length=1)]
    synthetic_cannon: SyntheticCannonSettings

    @field_validator("sources")
    @classmethod
    def _named_once(cls, sources: list[str]) -> list[str]:
        if len(set(sources)) < len(sources):
            raise ValueError("a source is named twice")
        return sources
