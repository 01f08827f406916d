"""Returns that the report page shows, and their file."""

from collections.abc import Sequence
from pathlib import Path
from typing import Annotated

from pydantic import BaseModel, ConfigDict, Field

from rallygap.pipeline.evaluation.example_shots import Forecast, Number
from rallygap.pipeline.io.artifacts import read_as, write_json

Joints = tuple[Number, Number, Number, Number, Number, Number]
Track = Forecast  # times and positions; also of measurements
Positive = Annotated[float, Field(gt=0, allow_inf_nan=False)]


class TimedForecast(BaseModel):
    """A forecast track, and when it was made (s from the launch)."""

    model_config = ConfigDict(extra="forbid")

    at: Number
    track: Track


class Return(BaseModel):
    """A shot that a policy played, returned or not; times are s from the launch.

    Attributes:
        name: of the shot: its set and its number in it.
        predictor: whose forecasts the policy got.
        outcome: ``returned`` or the fault.
        horizon: the policy's middle forecast horizon, s.
        hit: when the racket met the ball; ``None`` without a hit.
        measured: measurements until the hit or the end of play.
        ball: its true path, up to the racket and on from there.
        frame: s between two poses of the arm, the first at the launch.
        joints: (T, 6) of the arm.
        forecasts: of each predictor, at every control step before the end.
    """

    model_config = ConfigDict(extra="forbid")

    name: str
    predictor: str
    outcome: str
    horizon: Positive
    hit: Number | None
    measured: Track
    ball: Track
    frame: Positive
    joints: Annotated[list[Joints], Field(min_length=2)]
    forecasts: dict[str, list[TimedForecast]]


def write_returns(path: Path, returns: Sequence[Return]) -> None:
    """Write examples as JSON."""
    write_json(path, [example.model_dump() for example in returns])


def read_returns(path: Path) -> list[Return]:
    """Read what ``write_returns`` wrote.

    Raises:
        InputError: the file is missing or breaks the schema; names the example and the field.
    """
    return read_as(path, list[Return], "sim2real")
