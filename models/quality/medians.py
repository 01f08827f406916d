"""Medians of what was returned, with intervals over the balls that came."""

import numpy as np
from numpy.typing import ArrayLike, NDArray

Floats = NDArray[np.float64]


def median_interval(
    values: ArrayLike, balls: ArrayLike, count: int, resamples: int, seed: int
) -> tuple[float, float, float]:
    """Return a median and the ends of its 95 % interval.

    Args:
        values: (R,) of returns.
        balls: (R,) which ball each of them returned, of 0 ... count - 1. Balls are resampled, not
            returns, each with what all policies make of it, those that nobody returned too.
        count: of the balls.
        resamples: of them; without any the interval is the median.
        seed: of the resamples.

    Returns:
        NaN where nothing was returned.
    """
    known, owners = np.asarray(values, dtype=np.float64), np.asarray(balls, dtype=np.int64)
    if not len(known):
        return np.nan, np.nan, np.nan
    median = float(np.median(known))
    drawn = np.random.default_rng(seed).multinomial(
        count, np.full(count, 1 / count), size=resamples
    )
    again = _medians(known, drawn[:, owners])
    if not len(again):
        return median, median, median
    low, high = np.quantile(again, [0.025, 0.975])
    return median, float(low), float(high)


def _medians(values: Floats, times: NDArray[np.int64]) -> Floats:
    """Return the medians of (R,) values, each counted (S, R) times, where any is counted."""
    order = np.argsort(values, kind="stable")
    upto = np.cumsum(times[:, order], axis=1)
    some = upto[upto[:, -1] > 0]
    total = some[:, -1:]
    lower = (some > (total - 1) // 2).argmax(axis=1)
    upper = (some > total // 2).argmax(axis=1)
    ordered = values[order]
    medians: Floats = (ordered[lower] + ordered[upper]) / 2
    return medians
