"""The design: which errors are planted, in which sizes, and which shots are diagnosed."""

from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from typing import Literal
from zlib import crc32

import numpy as np

Place = Literal["simulator", "recordings"]

DISTORTION = "camera_distortion"  # of positions, a random field
# Sizes of errors in minimum detectable effects of the diagnosed shots, and of distortions in m.
SIZES = {"2x": 2.0, "4x": 4.0, "8x": 8.0}
DISTORTION_SIZES = {"2 mm": 0.002, "4 mm": 0.004, "8 mm": 0.008}

# Parameters of planted errors, each with the largest error that is still plausible, in its unit.
IN_SIMULATOR = {
    "drag.cd": 0.4,
    "magnus.cm": 0.5,
    "gravity.g": 4.0,
    "table_bounce.restitution": 0.25,
    "table_bounce.friction": 0.25,
    "wind.x": 5.0,
    "wind.y": 5.0,
    "frame_tilt.x": 0.15,
}
# How recordings are changed: by the parameter that describes it.
IN_RECORDINGS = {
    "position_scale.s": 0.1,
    "frame_tilt.y": 0.1,
    "clock_rate.d": 0.15,
    "spin_axis_bias.x": 0.6,
    "spin_gain.s": 0.45,
}


@dataclass(frozen=True)
class PlantedError:
    """One error that is planted.

    Attributes:
        place: where.
        identity: of the parameter that describes it, or ``DISTORTION``.
        size: its name among ``SIZES`` or ``DISTORTION_SIZES``.
        value: how large it is, in the parameter's unit; distortion in m.
    """

    place: Place
    identity: str
    size: str
    value: float


@dataclass(frozen=True)
class Question:
    """One diagnosis whose answer is known.

    Attributes:
        set: the measured set.
        fold: which part of its recordings is diagnosed, from 0.
        error: that is planted; None in the unplanted question.
    """

    set: str
    fold: int
    error: PlantedError | None = None

    @property
    def name(self) -> str:
        """Stem of a file's name, which no other question of its set has."""
        error = self.error
        parts = (error.place, error.identity, error.size) if error else ("unplanted",)
        return ".".join([str(self.fold), *parts])

    @property
    def seed(self) -> int:
        """Of what is random in the error: the same for all errors of a fold."""
        return crc32(f"{self.set}/{self.fold}".encode())


def questions(set_name: str, fold: int, limits: Mapping[str, float]) -> list[Question]:
    """Return all questions about a fold of a set but the unplanted one.

    Args:
        set_name: of the measured set.
        fold: which part of its recordings is diagnosed.
        limits: the minimum detectable effects of the fold, by identity.
    """
    return [Question(set_name, fold, error) for error in planted_errors(limits)]


def planted_errors(limits: Mapping[str, float]) -> Iterator[PlantedError]:
    """Yield the errors that shots with these minimum detectable effects could show.

    Errors of what the shots do not identify, and implausibly large ones, are not planted.
    """
    places: dict[Place, dict[str, float]] = {
        "simulator": IN_SIMULATOR,
        "recordings": IN_RECORDINGS,
    }
    for place, largest in places.items():
        for identity, most in largest.items():
            for size, times in SIZES.items():
                value = times * limits.get(identity, np.inf)
                if value <= most:
                    yield PlantedError(place, identity, size, value)
    for size, value in DISTORTION_SIZES.items():
        yield PlantedError("recordings", DISTORTION, size, value)
