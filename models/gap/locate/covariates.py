"""Covariates that a discrepancy may grow with: one number or kind a shot."""

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from rallygap.models.ball.state import SPIN, VELOCITY
from rallygap.models.ball.types import Floats
from rallygap.models.gap.fit.linearize import Linearised
from rallygap.models.gap.settings import LocateSettings

UP = np.array([0.0, 0.0, 1.0])
TURNS = ("topspin", "sidespin left", "backspin", "sidespin right")  # a quarter turn apart


@dataclass(frozen=True)
class Axis:
    """A covariate of B shots.

    Attributes:
        name: of the axis.
        unit: of its values, empty for kinds.
        values: (B,) of the shots, or numbers of their kinds; NaN where it has none.
        kinds: names, where the shots are of different kinds.
    """

    name: str
    unit: str
    values: Floats
    kinds: tuple[str, ...] = ()


def axes(linear: Linearised, places: Floats, settings: LocateSettings) -> list[Axis]:
    """Return the covariates of shots, from the (B, 3) places, m, at the horizon of the trends."""
    return [
        Axis("speed at launch", "m/s", np.linalg.norm(linear.nuisance[:, VELOCITY], axis=1)),
        *_of_spin(linear, settings.min_axis_spin),
        Axis("height", "m", places[:, 2]),
        Axis("place across the table", "m", places[:, 0]),
        Axis("place along the table", "m", places[:, 1]),
        _direction(linear),
    ]


def course_frames(linear: Linearised) -> Floats:
    """Return (B, 3, 3) directions along a shot's horizontal course, across it to the right, up."""
    along = linear.nuisance[:, VELOCITY] * (1 - UP)
    along /= np.maximum(np.linalg.norm(along, axis=1, keepdims=True), 1e-9)
    return np.stack([along, np.cross(along, UP), np.broadcast_to(UP, along.shape)], axis=1)


def _of_spin(linear: Linearised, min_spin: float) -> Iterator[Axis]:
    """Yield the axes of spin; fitted spins without a label follow the errors of positions."""
    spins = linear.nuisance[:, SPIN]
    size = np.linalg.norm(spins, axis=1)
    labelled = linear.labelled.any(axis=1)
    yield Axis("spin at launch", "rad/s", np.where(labelled, size, np.nan))
    along = course_frames(linear)[:, 0]
    left = np.cross(UP, along)
    angle = np.arctan2(spins[:, 2], (spins * left).sum(axis=1))
    quarter = np.round(angle / (np.pi / 2)) % len(TURNS)
    gyro = np.abs((spins * along).sum(axis=1)) > size / np.sqrt(2.0)
    kind = np.where(gyro, len(TURNS), quarter)
    reliable = labelled & (size > min_spin)
    yield Axis("spin axis", "", np.where(reliable, kind, np.nan), (*TURNS, "along the course"))


def _direction(linear: Linearised) -> Axis:
    towards = (linear.nuisance[:, VELOCITY][:, 1] > 0).astype(np.float64)
    return Axis("direction of play", "", towards, ("towards −y", "towards +y"))
