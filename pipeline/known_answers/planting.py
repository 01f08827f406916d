"""Plants errors in a simulator or in recordings, and says what a correct verdict then finds."""

from collections.abc import Callable, Mapping
from dataclasses import replace

import numpy as np
from scipy.spatial.transform import Rotation

from rallygap.models.ball.simulator import Simulator
from rallygap.models.ball.types import Floats
from rallygap.models.gap.fit.shots import Shots
from rallygap.models.gap.hypotheses import Hypothesis
from rallygap.pipeline.known_answers.design import DISTORTION, PlantedError

LENGTH = 0.8  # m, over which the distortion changes
WAVES = 64  # that the distortion is a sum of


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
        references: values in the unchanged recordings, by identity.
        seed: of the distortion.
    """
    if error is None:
        return simulator, shots
    if error.place == "simulator":
        return _spoiled(simulator, error, references[error.identity]), shots
    return simulator, _CHANGES[error.identity](shots, error.value, seed)


def true_values(error: PlantedError, references: Mapping[str, float]) -> dict[str, float]:
    """Return the values by identity that a correct verdict finds; none for a distortion.

    Args:
        error: that is planted.
        references: values in the unchanged recordings, by identity.
    """
    if error.place == "simulator":
        return {error.identity: references[error.identity]}
    if error.identity == "frame_tilt.y":
        # The table turns with the frame; its normal is tilted the other way.
        signs = {"frame_tilt.y": 1, "table_tilt.y": -1}
        return {name: references[name] + sign * error.value for name, sign in signs.items()}
    if error.identity == "spin_axis_bias.x":
        return {error.identity: references[error.identity] + error.value}
    if error.identity == DISTORTION:
        return {}
    return {error.identity: (1 + references[error.identity]) * (1 + error.value) - 1}


def _spoiled(simulator: Simulator, error: PlantedError, value: float) -> Simulator:
    """Add an error to a parameter's reference value; subtract it where the range ends."""
    hypothesis = Hypothesis.from_identity(error.identity)
    high = hypothesis.declaration.bounds[1]
    changed = value + error.value if value + error.value <= high else value - error.value
    return hypothesis.at(simulator, changed)


def _scaled(shots: Shots, share: float, seed: int) -> Shots:
    return replace(shots, positions=(1 + share) * shots.positions)


def _turned(shots: Shots, angle: float, seed: int) -> Shots:
    """Turn positions and spin labels about x: gravity leans towards +y."""
    positions, labels = _rotated(shots.positions, angle), _rotated(shots.labels, angle)
    return replace(shots, positions=positions, labels=labels)


def _with_fast_clock(shots: Shots, share: float, seed: int) -> Shots:
    times, label_times = (1 + share) * shots.times, (1 + share) * shots.label_times
    return replace(shots, times=times, label_times=label_times)


def _distorted(shots: Shots, size: float, seed: int) -> Shots:
    """Shift positions by a smooth random field with this standard deviation of a coordinate, m."""
    random = np.random.default_rng(seed)
    waves = random.normal(0.0, 1 / LENGTH, (3, WAVES))
    phases = random.uniform(0.0, 2 * np.pi, WAVES)
    amplitudes = random.normal(0.0, size * np.sqrt(2 / WAVES), (WAVES, 3))
    field = np.cos(shots.positions @ waves + phases) @ amplitudes
    return replace(shots, positions=shots.positions + field)


def _with_turned_labels(shots: Shots, angle: float, seed: int) -> Shots:
    return replace(shots, labels=_rotated(shots.labels, angle))


def _with_scaled_labels(shots: Shots, share: float, seed: int) -> Shots:
    return replace(shots, labels=(1 + share) * shots.labels)


def _rotated(vectors: Floats, angle: float) -> Floats:
    """Return (..., 3) vectors turned about x by an angle in rad; NaN stays NaN."""
    turned: Floats = vectors @ Rotation.from_rotvec([angle, 0.0, 0.0]).as_matrix().T
    return turned


_CHANGES: dict[str, Callable[[Shots, float, int], Shots]] = {
    "position_scale.s": _scaled,
    "frame_tilt.y": _turned,
    "clock_rate.d": _with_fast_clock,
    DISTORTION: _distorted,
    "spin_axis_bias.x": _with_turned_labels,
    "spin_gain.s": _with_scaled_labels,
}
