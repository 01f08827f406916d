"""Rehearsal: shots as they would have been measured, were a simulator without fault.

Each ball starts as it did and meets the table as the simulator says, with a kick of the size that
bounces scatter by; the sensor errs anew, at the same times, by noise of the size found.
"""

from dataclasses import replace

import numpy as np

from models.ball.simulator import Simulator
from models.ball.types import Floats
from models.gap.fit.measurement import Moments, Seen, seen
from models.gap.fit.noise import Noise
from models.gap.fit.shot_fit import MOST_KICKS
from models.gap.fit.shots import Shots
from models.gap.fit.trajectory import KICK_SIZE


def rehearsed(
    shots: Shots, simulator: Simulator, states: Floats, noise: Noise, random: np.random.Generator
) -> Shots:
    """Return shots measured anew.

    Args:
        shots: B of them, whose times and labels' times are kept.
        simulator: that flies the balls, and sees them with its sensor effects.
        states: (B, 9) at the first sample.
        noise: of the sensor, and scatter of bounces.
        random: draws both.
    """
    kicks = random.standard_normal((len(shots), MOST_KICKS, KICK_SIZE)) * noise.scatter
    unknowns = np.hstack([states, kicks.reshape(len(shots), -1)])
    view = seen(simulator, Moments.of(shots), unknowns)
    positions = view.positions + _position_errors(shots, view, noise, random)
    return replace(shots, positions=positions, labels=_labels(shots, view, noise, random))


def _position_errors(shots: Shots, view: Seen, noise: Noise, random: np.random.Generator) -> Floats:
    """Return (B, N, 3) m: white noise, one that changes slowly, and that of the time stamps."""
    white = noise.white * random.standard_normal(view.positions.shape)
    stamps = noise.timing * random.standard_normal(shots.times.shape)
    slow = noise.slow * random.standard_normal(view.positions.shape)
    kept = np.exp(-np.diff(shots.times, axis=1) / noise.slow_time)[..., None]
    for i in range(kept.shape[1]):
        slow[:, i + 1] = kept[:, i] * slow[:, i] + np.sqrt(1 - kept[:, i] ** 2) * slow[:, i + 1]
    errors: Floats = white + slow + stamps[..., None] * view.velocities
    return errors


def _labels(shots: Shots, view: Seen, noise: Noise, random: np.random.Generator) -> Floats:
    """Return (B, L, 3) labels that err in every row, and in all rows of a shot alike."""
    rows = noise.label * random.standard_normal(view.labels.shape)
    common = noise.label_common * random.standard_normal((len(shots), 1, 3))
    sizes = np.linalg.norm(view.labels, axis=-1, keepdims=True)
    labels: Floats = np.where(
        shots.labelled[..., None], view.labels + sizes * (rows + common), np.nan
    )
    return labels
