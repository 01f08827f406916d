"""The design: which errors are planted, in which sizes, and what a correct verdict then finds."""

from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass, replace
from typing import Literal
from zlib import crc32

import numpy as np
from scipy.spatial.transform import Rotation

from rallygap.models.ball.simulator import Simulator
from rallygap.models.ball.types import Floats
from rallygap.models.gap.fit.shots import Shots
from rallygap.models.gap.hypotheses import Hypothesis

Place = Literal["simulator", "recordings"]

DISTORTION = "camera_distortion"  # of positions, a random field
LENGTH = 0.8  # m, over which the distortion changes
WAVES = 64  # that the distortion is a sum of
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


def planted_errors(limits: Mapping[str, float]) -> Iterator[PlantedError]:
    """Yield the errors that shots could show, none of them implausibly large.

    Args:
        limits: minimum detectable effects of the shots, by identity.
    """
    places: dict[Place, dict[str, float]] = {"simulator": IN_SIMULATOR, "recordings": IN_RECORDINGS}
    for place, largest in places.items():
        for identity, most in largest.items():
            for size, times in SIZES.items():
                value = times * limits.get(identity, np.inf)
                if value <= most:
                    yield PlantedError(place, identity, size, value)
    for size, value in DISTORTION_SIZES.items():
        yield PlantedError("recordings", DISTORTION, size, value)


def plant(
    error: PlantedError | None,
    simulator: Simulator,
    shots: Shots,
    references: Mapping[str, float],
    seed: int,
) -> tuple[Simulator, Shots]:
    """Return the simulator and the shots of a question.

    Args:
        error: None changes nothing.
        simulator: without the error.
        shots: without the error.
        references: values in the unchanged recordings, by identity. An error in the simulator is
            added to them, or subtracted where the parameter's range ends.
        seed: of the distortion.
    """
    if error is None:
        return simulator, shots
    if error.identity == DISTORTION:
        return simulator, _distorted(shots, error.value, seed)
    if error.place == "recordings":
        return simulator, _CHANGES[error.identity](shots, error.value)
    hypothesis, value = Hypothesis.from_identity(error.identity), references[error.identity]
    fits = value + error.value <= hypothesis.declaration.bounds[1]
    return hypothesis.at(simulator, value + error.value if fits else value - error.value), shots


def true_values(error: PlantedError, references: Mapping[str, float]) -> dict[str, float]:
    """Return the values by identity that a correct verdict finds; none for a distortion.

    Args:
        error: that is planted.
        references: values in the unchanged recordings, by identity.
    """
    identity, value = error.identity, error.value
    if identity == DISTORTION:
        return {}
    if error.place == "simulator":
        return {identity: references[identity]}
    if identity == "frame_tilt.y":
        # The table turns with the frame; its normal is tilted the other way.
        signs = {"frame_tilt.y": 1, "table_tilt.y": -1}
        return {name: references[name] + sign * value for name, sign in signs.items()}
    if identity == "spin_axis_bias.x":
        return {identity: references[identity] + value}
    return {identity: (1 + references[identity]) * (1 + value) - 1}


def _distorted(shots: Shots, size: float, seed: int) -> Shots:
    """Shift positions by a smooth random field with this standard deviation of a coordinate, m."""
    random = np.random.default_rng(seed)
    waves = random.normal(0.0, 1 / LENGTH, (3, WAVES))
    phases = random.uniform(0.0, 2 * np.pi, WAVES)
    amplitudes = random.normal(0.0, size * np.sqrt(2 / WAVES), (WAVES, 3))
    field = np.cos(shots.positions @ waves + phases) @ amplitudes
    return replace(shots, positions=shots.positions + field)


def _scaled(shots: Shots, share: float) -> Shots:
    return replace(shots, positions=(1 + share) * shots.positions)


def _turned(shots: Shots, angle: float) -> Shots:
    """Turn positions and spin labels about x: gravity leans towards +y."""
    return replace(_with_turned_labels(shots, angle), positions=_rotated(shots.positions, angle))


def _with_fast_clock(shots: Shots, share: float) -> Shots:
    times, label_times = (1 + share) * shots.times, (1 + share) * shots.label_times
    return replace(shots, times=times, label_times=label_times)


def _with_turned_labels(shots: Shots, angle: float) -> Shots:
    return replace(shots, labels=_rotated(shots.labels, angle))


def _with_scaled_labels(shots: Shots, share: float) -> Shots:
    return replace(shots, labels=(1 + share) * shots.labels)


def _rotated(vectors: Floats, angle: float) -> Floats:
    """Return (..., 3) vectors turned about x by an angle in rad; NaN stays NaN."""
    return np.asarray(vectors @ Rotation.from_rotvec([angle, 0.0, 0.0]).as_matrix().T)


_CHANGES: dict[str, Callable[[Shots, float], Shots]] = {
    "position_scale.s": _scaled,
    "frame_tilt.y": _turned,
    "clock_rate.d": _with_fast_clock,
    "spin_axis_bias.x": _with_turned_labels,
    "spin_gain.s": _with_scaled_labels,
}
