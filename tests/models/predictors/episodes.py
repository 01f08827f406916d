"""Simulated episodes for the tests of learned predictors, with noise and lost samples."""

import numpy as np

from rallygap.models.predictors.windows import Episode
from tests.models.predictors.balls import FIRST, TRUTH

GRID = 0.005 * np.arange(121)


def flown(first=FIRST[0], times=GRID, noise=0.0, spin_noise=0.0, seed=0):
    """The episode of a ball, with true velocities; its first state is that of the first sample."""
    random = np.random.default_rng(seed)
    flight = TRUTH.fly(first[None], times - times[0])
    met = flight.contacts.time[0][: flight.contacts.count[0]]
    states = flight.states[0]
    return Episode(
        times=times,
        positions=states[:, :3] + noise * random.normal(size=(len(times), 3)),
        velocities=states[:, 3:6],
        spins=states[:, 6:] + spin_noise * random.normal(size=(len(times), 3)),
        outlier=np.zeros(len(times), dtype=bool),
        arc=np.searchsorted(met, times - times[0]),
        bounces=times[0] + met,
    )


def degraded(episode, seed=0, lost=0.1, outliers=0.05, unlabelled=0.2):
    """The episode with samples lost (not the first), outliers, and spins without a label."""
    random = np.random.default_rng(seed)
    kept = random.random(len(episode.times)) >= lost
    kept[0] = True
    outlier = random.random(len(episode.times)) < outliers
    moved = np.where(outlier[:, None], episode.positions + 0.3, episode.positions)
    hidden = random.random((len(episode.times), 1)) < unlabelled
    velocities = np.where(outlier[:, None], np.nan, episode.velocities)
    spins = np.where(hidden, np.nan, episode.spins)
    rows = (episode.times, moved, velocities, spins, outlier, episode.arc)
    return Episode(*(row[kept] for row in rows), episode.bounces)
