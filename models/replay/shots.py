"""Shots: measured balls on their way to the robot, made ready to be replayed."""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from models.policy.incoming_balls import PATH_STEP
from models.policy.measurements import measure
from models.policy.settings import SensorNoise
from models.predictors.protocol import TICK
from models.predictors.windows import ROUNDING, Episode

Floats = NDArray[np.float64]
Booleans = NDArray[np.bool_]

HALF_TURN = np.array([-1.0, -1.0, 1.0])  # about the vertical, of places, velocities and spins
NOTHING_MEASURED = Episode(
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
    """A ball that was measured, and where it truly was.

    Attributes:
        measured: its samples, the first of them at time zero: the launch.
        known: (n, 9) true states ``PATH_STEP`` apart from the launch on; n is between 1 and the N
            of ``Incoming``.
        bounces: (C,) s from the launch, when it met the table as far as that is known.
    """

    measured: Episode
    known: Floats
    bounces: Floats


def from_launch(episode: Episode) -> Episode:
    """Return the episode with its first sample at time zero."""
    start = episode.times[0]
    return replace(episode, times=episode.times - start, bounces=episode.bounces - start)


def flies_away(episode: Episode) -> bool:
    """Return whether the ball flies away from the robot most of the time."""
    return bool(np.median(episode.velocities[:, 1]) > 0)


def half_turned(episode: Episode) -> Episode:
    """Return the episode as the player at the other end sees it."""
    return replace(
        episode,
        positions=episode.positions * HALF_TURN,
        velocities=episode.velocities * HALF_TURN,
        spins=episode.spins * HALF_TURN,
    )


def measure_on(
    shots: Sequence[Shot],
    path: Floats,
    until: Floats,
    noise: SensorNoise,
    random: np.random.Generator,
) -> list[Shot]:
    """Return the shots with what cameras see of the balls beyond what is known of them.

    They measure every 5 ms after the last sample; spins only of balls whose spin was measured last.
    Samples beyond the known path are of another flight than the one that is replayed, and go.

    Args:
        shots: B.
        path: (B, N, 9) as in ``Incoming``.
        until: (B,) s from the launch, after which nothing is measured.
        noise: of every measurement.
        random: where the noise comes from.
    """
    seen = measure(path, until, noise, random)
    parts = zip(shots, seen.states, seen.mask[..., 0], strict=True)
    return [replace(shot, measured=_continued(shot, *later)) for shot, *later in parts]


def _continued(shot: Shot, states: Floats, seen: Booleans) -> Episode:
    """Return a shot's samples and after them those of (M, 6) states, 5 ms apart, that are seen."""
    before = shot.measured
    own = before.times <= PATH_STEP * len(shot.known) + ROUNDING
    times = TICK * np.arange(float(len(states)))
    after = seen & (times > before.times[own].max(initial=-TICK) + TICK / 2)
    count = int(after.sum())
    labelled = np.isfinite(before.spins[own][-1:]).all()
    return Episode(
        times=np.concatenate([before.times[own], times[after]]),
        positions=np.concatenate([before.positions[own], states[after, :3]]),
        velocities=np.concatenate([before.velocities[own], np.full((count, 3), np.nan)]),
        spins=np.concatenate(
            [before.spins[own], np.where(labelled, states[after, 3:], np.nan)],
        ),
        outlier=np.concatenate([before.outlier[own], np.zeros(count, dtype=np.bool_)]),
        arc=np.concatenate([before.arc[own], np.full(count, before.arc[own].max(initial=0))]),
        bounces=before.bounces,
    )
