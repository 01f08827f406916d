"""Returns to look at: how a policy played a ball, and what it was told of it at every tick."""

from collections.abc import Sequence
from pathlib import Path
from typing import Annotated

from pydantic import BaseModel, ConfigDict, Field

from pipeline.evaluation.example_shots import Forecast, Number
from pipeline.io.artifacts import read_as, write_json

Joints = tuple[Number, Number, Number, Number, Number, Number]
Track = Forecast  # where something is at which time; of a ball that was measured, too
Positive = Annotated[float, Field(gt=0, allow_inf_nan=False)]


class Told(BaseModel):
    """A forecast: when it was made (s from the launch), and where it sees the ball."""

    model_config = ConfigDict(extra="forbid")

    at: Number
    track: Track


class Return(BaseModel):
    """A ball that a policy played, returned or not; times are s from the launch.

    Attributes:
        name: of the ball: its set, and its number among the replayed.
        told_by: whom the policy was told of it by.
        outcome: how it ended, such as ``returned``.
        horizon: the middle one of those that the policy is told of, s.
        hit: when the racket met the ball; ``None`` if it did not.
        measured: what was measured until the ball was hit or gone.
        ball: its true path, up to the racket and on from there.
        frame: s between two poses of the arm, the first at the launch.
        joints: (T, 6) of the arm.
        forecasts: predictor name -> its forecast at every tick before the end.
    """

    model_config = ConfigDict(extra="forbid")

    name: str
    told_by: str
    outcome: str
    horizon: Positive
    hit: Number | None
    measured: Track
    ball: Track
    frame: Positive
    joints: Annotated[list[Joints], Field(min_length=2)]
    forecasts: dict[str, list[Told]]


def write_returns(path: Path, returns: Sequence[Return]) -> None:
    """Write returns as JSON."""
    write_json(path, [one.model_dump() for one in returns])


def read_returns(path: Path) -> list[Return]:
    """Read what ``write_returns`` wrote.

    Raises:
        InputError: if the file is missing or breaks the schema, naming the return and the field.
    """
    return read_as(path, list[Return], "sim2real")
