"""The design: which errors are planted, in which sizes, and which shots are diagnosed."""

from collections.abc import Iterator
from dataclasses import dataclass
from typing import Literal
from zlib import crc32

import numpy as np
from numpy.typing import NDArray

from models.gap.fit.shots import Shots
from pipeline.runtime.errors import InputError

Place = Literal["simulator", "recordings"]
Values = dict[str, tuple[float, float, float]]  # of the sizes, by identity

SIZES = ("small", "medium", "large")
DISTORTION = "camera_distortion"  # of positions; no effect of the catalogue describes it

# The sizes are fixed, of the order of the minimum detectable effects in a third of a measured set.
# What is added to a value of the simulator, in the parameter's unit.
IN_SIMULATOR: Values = {
    "drag.cd": (0.05, 0.1, 0.2),
    "magnus.cm": (0.1, 0.2, 0.4),
    "gravity.g": (0.25, 0.5, 1.0),
    "table_bounce.restitution": (0.025, 0.05, 0.1),
    "table_bounce.friction": (0.05, 0.1, 0.2),
    "wind.x": (0.5, 1.0, 2.0),
    "wind.y": (0.5, 1.0, 2.0),
    "frame_tilt.x": (0.015, 0.03, 0.06),
}
# How recordings are changed: by the parameter that describes it, in its unit; distortion in m.
IN_RECORDINGS: Values = {
    "position_scale.s": (0.02, 0.04, 0.08),
    "frame_tilt.y": (0.015, 0.03, 0.06),
    "clock_rate.d": (0.02, 0.04, 0.08),
    DISTORTION: (0.002, 0.004, 0.008),
}
IN_LABELS: Values = {
    "spin_axis_bias.x": (0.1, 0.2, 0.4),
    "spin_gain.s": (0.1, 0.2, 0.4),
}


@dataclass(frozen=True)
class PlantedError:
    """One error that is planted.

    Attributes:
        place: where.
        identity: of the parameter that describes it, or ``DISTORTION``.
        size: its name among ``SIZES``.
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


def questions(set_name: str, shots: Shots, count: int) -> list[Question]:
    """Return all questions about a set in ``count`` folds, the unplanted one of each fold first.

    Errors of spin labels are planted only where there are labels.
    """
    errors = list(planted_errors(labelled=bool(shots.labelled.any())))
    return [Question(set_name, fold, error) for fold in range(count) for error in (None, *errors)]


def planted_errors(labelled: bool) -> Iterator[PlantedError]:
    """Yield the planted errors, with or without those of spin labels."""
    in_recordings = IN_RECORDINGS | (IN_LABELS if labelled else {})
    places: dict[Place, Values] = {
        "simulator": IN_SIMULATOR,
        "recordings": in_recordings,
    }
    for place, errors in places.items():
        for identity, values in errors.items():
            for size, value in zip(SIZES, values, strict=True):
                yield PlantedError(place, identity, size, value)


def fold_numbers(set_name: str, shots: Shots, count: int) -> NDArray[np.int64]:
    """Return (B,) the fold of each shot; all shots of a recording are in the same one.

    Raises:
        InputError: there are fewer recordings than folds.
    """
    names, member = np.unique(shots.groups.astype(str), return_inverse=True)
    if len(names) < count:
        problem = f"has shots of {len(names)} recordings, too few for {count} folds"
        raise InputError(set_name, problem)
    order: NDArray[np.int64] = np.random.default_rng(0).permutation(len(names))
    return order[member] % count
