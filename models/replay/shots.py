"""Shots: measured balls on their way to the robot, prepared for replay."""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from rallygap.models.ball.types import Bools, Floats
from rallygap.models.policy.incoming_balls import PATH_STEP
from rallygap.models.policy.measurements import measure
from rallygap.models.policy.settings import SensorNoise
from rallygap.models.predictors.protocol import TICK
from rallygap.models.predictors.windows import ROUNDING, Episode

HALF_TURN = np.array([-1.0, -1.0, 1.0])  # about the vertical, of places, velocities and spins
NO_MEASUREMENTS = Episode(
    times=np.empty(0),
    positions=np.empty((0, 3)),
    velocities=np.empty((0, 3)),
    spins=np.empty((0, 3)),
    outlier=np.empty(0, dtype=bool),
    arc=np.empty(0, dtype=np.int64),
    bounces=np.empty(0),
)


@dataclass(frozen=True)
class Shot:
    """A measured ball and its true path.

    Attributes:
        measured: its samples, the first of them at time zero: the launch.
        known: (n, 9) true states ``PATH_STEP`` apart from the launch on; n is between 1 and the N
            of ``IncomingBalls``.
        bounces: (C,) s from the launch, of the known bounces on the table.
    """

    measured: Episode
    known: Floats
    bounces: Floats


def from_launch(episode: Episode) -> Episode:
    """Return the episode with its first sample at time zero."""
    start = episode.times[0]
    return replace(episode, times=episode.times - start, bounces=episode.bounces - start)


def flies_away(episode: Episode) -> bool:
    """Return whether the ball mostly flies away from the robot."""
    return bool(np.median(episode.velocities[:, 1]) > 0)


def half_turn(episode: Episode) -> Episode:
    """Return the episode rotated by half a turn about the vertical."""
    return replace(
        episode,
        positions=episode.positions * HALF_TURN,
        velocities=episode.velocities * HALF_TURN,
        spins=episode.spins * HALF_TURN,
    )


def extend_measurements(
    shots: Sequence[Shot],
    path: Floats,
    until: Floats,
    noise: SensorNoise,
    random: np.random.Generator,
) -> list[Shot]:
    """Return the shots with simulated measurements after their known paths.

    Every 5 ms after the last sample; spins only where the last sample has one. Samples beyond the
    known path belong to another flight than the replayed one and are dropped.

    Args:
        shots: B.
        path: (B, N, 9) as in ``IncomingBalls``.
        until: (B,) s from the launch, after which nothing is measured.
        noise: of every measurement.
        random: of the noise.
    """
    states, mask = measure(path, until, noise, random)
    parts = zip(shots, states, mask[..., 0], strict=True)
    return [replace(shot, measured=_extended(shot, *later)) for shot, *later in parts]


def _extended(shot: Shot, states: Floats, measured: Bools) -> Episode:
    """Return a shot's samples followed by those of (M, 6) states, 5 ms apart, that are measured."""
    before = shot.measured
    kept = before.times <= PATH_STEP * len(shot.known) + ROUNDING
    times = TICK * np.arange(float(len(states)))
    after = measured & (times > before.times[kept].max(initial=-TICK) + TICK / 2)
    count = int(after.sum())
    labelled = np.isfinite(before.spins[kept][-1:]).all()
    later = {
        "times": times[after],
        "positions": states[after, :3],
        "velocities": np.full((count, 3), np.nan),
        "spins": np.where(labelled, states[after, 3:], np.nan),
        "outlier": np.zeros(count, dtype=np.bool_),
        "arc": np.full(count, before.arc[kept].max(initial=0)),
    }
    samples = {
        name: np.concatenate([getattr(before, name)[kept], values])
        for name, values in later.items()
    }
    return replace(before, **samples)
