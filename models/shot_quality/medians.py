"""Medians of what was returned, with intervals over the balls that came."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

Floats = NDArray[np.float64]


@dataclass(frozen=True)
class Resampled:
    """A number that tells of returns, and what it is of resamples of the balls.

    Attributes:
        value: NaN where nothing was returned.
        again: (S,) of the resamples; NaN where nothing of one was returned.
    """

    value: float
    again: Floats

    def interval(self) -> tuple[float, float, float]:
        """Return the number and the ends of its 95 % interval; without resamples these are it."""
        known = self.again[~np.isnan(self.again)]
        if not len(known):
            return self.value, self.value, self.value
        low, high = np.quantile(known, [0.025, 0.975])
        return self.value, float(low), float(high)

    def over(self, other: "Resampled") -> "Resampled":
        """Return how many times another number of the same balls it is; NaN over none or less.

        Both must be resampled from one seed: each resample then has the same balls in both, so
        what makes a ball hard is in neither's favour.
        """
        return Resampled(
            float(_over(self.value, other.value)), np.asarray(_over(self.again, other.again))
        )


def resampled_median(
    values: ArrayLike, balls: ArrayLike, count: int, resamples: int, seed: int
) -> Resampled:
    """Return a median, of the returns and of resamples of the balls.

    Args:
        values: (R,) of returns.
        balls: (R,) which ball each of them returned, of 0 ... count - 1. Balls are resampled, not
            returns, each with what all policies make of it, those that nobody returned too.
        count: of the balls.
        resamples: of them.
        seed: of the resamples.
    """
    known, owners = np.asarray(values, dtype=np.float64), np.asarray(balls, dtype=np.int64)
    if not len(known):
        return Resampled(np.nan, np.full(resamples, np.nan))
    drawn = np.random.default_rng(seed).multinomial(
        count, np.full(count, 1 / count), size=resamples
    )
    return Resampled(float(np.median(known)), _medians(known, drawn[:, owners]))


def _medians(values: Floats, times: NDArray[np.int64]) -> Floats:
    """Return the medians of (R,) values, each counted (S, R) times; NaN where none is counted."""
    order = np.argsort(values, kind="stable")
    upto = np.cumsum(times[:, order], axis=1)
    total = upto[:, -1:]
    lower = (upto > (total - 1) // 2).argmax(axis=1)
    upper = (upto > total // 2).argmax(axis=1)
    ordered = values[order]
    return np.where(total[:, 0] > 0, (ordered[lower] + ordered[upper]) / 2, np.nan)


def _over(one: ArrayLike, other: ArrayLike) -> Floats:
    below = np.asarray(other, dtype=np.float64)
    return np.asarray(one) / np.where(below > 0, below, np.nan)
