"""Example shots for the 3-D view: measured samples and each predictor's forecast."""

from collections.abc import Sequence
from itertools import pairwise
from pathlib import Path
from typing import Annotated, Self

from pydantic import BaseModel, ConfigDict, Field, model_validator

from rallygap.pipeline.io.artifacts import read_as, write_json

MOST_SHOTS = 20  # more would make the page heavy

Number = Annotated[float, Field(allow_inf_nan=False)]
Point = tuple[Number, Number, Number]


class Forecast(BaseModel):
    """One predictor's forecast: times (s, the recording's clock) and positions (m, table frame)."""

    model_config = ConfigDict(extra="forbid")

    t: list[Number] = Field(min_length=1)
    position: list[Point]

    @model_validator(mode="after")
    def _check(self) -> Self:
        _check_path(self.t, self.position, "position")
        return self


class Shot(BaseModel):
    """One measured shot of an episode and its forecasts.

    Attributes:
        episode_id: of the episode.
        source: of the episode.
        t: times of the measured samples (s, the recording's clock).
        measured: measured positions (m, table frame), one for each time.
        anchor: time of the last sample in the history (s).
        forecasts: after the anchor, by predictor.
    """

    model_config = ConfigDict(extra="forbid")

    episode_id: str
    source: str
    t: list[Number] = Field(min_length=1)
    measured: list[Point]
    anchor: Number
    forecasts: dict[str, Forecast]

    @model_validator(mode="after")
    def _check(self) -> Self:
        _check_path(self.t, self.measured, "measured")
        if not self.t[0] <= self.anchor <= self.t[-1]:
            raise ValueError("anchor must lie within the measured times")
        return self


Shots = Annotated[list[Shot], Field(max_length=MOST_SHOTS)]


def _check_path(times: Sequence[float], points: Sequence[Point], name: str) -> None:
    if len(times) != len(points):
        raise ValueError(f"{name} has {len(points)} points for {len(times)} times")
    if any(later <= earlier for earlier, later in pairwise(times)):
        raise ValueError("t must increase")


def write_shots(path: Path, shots: Sequence[Shot]) -> None:
    """Write shots as JSON."""
    write_json(path, [shot.model_dump() for shot in shots])


def read_shots(path: Path) -> list[Shot]:
    """Read what ``write_shots`` wrote.

    Raises:
        InputError: if the file is missing or breaks the schema, naming the shot and the field.
    """
    return read_as(path, Shots, "evaluate_predictor")
