"""Horizons: what a prediction observes of a shot, and how long after that its error is taken."""

from dataclasses import replace

import numpy as np

from rallygap.models.ball.types import Floats
from rallygap.models.gap.fit.shots import Shots
from rallygap.models.gap.settings import GapSettings
from rallygap.models.gap.types import Bools


def last_observed_time(shots: Shots, settings: GapSettings) -> Floats:
    """Return (B, 1) times of the last samples that a prediction observes, s."""
    place = min(settings.observed_samples, shots.times.shape[1]) - 1
    return shots.times[:, place : place + 1]


def first_samples(shots: Shots, count: int) -> Shots:
    """Return the first samples of shots, and the labels up to the last of them."""
    last = shots.times[:, count - 1 : count]
    known = np.asarray(shots.label_times <= last)
    width = int(known.sum(axis=1).max(initial=0))
    labels = np.where(known[..., None], shots.labels, np.nan)[:, :width]
    return replace(
        shots,
        times=shots.times[:, :count],
        positions=shots.positions[:, :count],
        valid=shots.valid[:, :count],
        shared=shots.shared[:, :count],
        label_times=np.where(known, shots.label_times, np.nan)[:, :width],
        labels=labels,
    )


def at_horizons(
    shots: Shots, values: Floats, usable: Bools, horizons: Floats, settings: GapSettings
) -> Floats:
    """Return (B, H, ...) means of (B, N, ...) values about (H,) horizons, NaN where there are none.

    Horizons are in s from the last sample that a prediction observes; only (B, N) usable samples
    count.
    """
    since = shots.times - last_observed_time(shots, settings)
    near = usable[:, None] & (np.abs(since[:, None] - horizons[:, None]) <= settings.horizon_window)
    count = near.sum(axis=2)
    shares = near / np.where(count > 0, count, np.nan)[..., None]
    means: Floats = np.einsum("bhn,bn...->bh...", shares, values, optimize=True)
    return means
