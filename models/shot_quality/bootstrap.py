"""Statistics with intervals bootstrapped over clusters: the balls played, or the matches."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from rallygap.models.ball.types import Floats, Integers
from rallygap.models.support.bootstrap import resampled_counts


@dataclass(frozen=True)
class Estimate:
    """A statistic, with its values on bootstrap resamples of the clusters.

    Attributes:
        value: NaN where it is not defined.
        resampled: (S,) on the resamples; NaN where it is not defined on one.
    """

    value: float
    resampled: Floats

    def interval(self) -> tuple[float, float, float]:
        """Return the value and the ends of its 95 % interval; without resamples, three values."""
        known = self.resampled[~np.isnan(self.resampled)]
        if not len(known):
            return self.value, self.value, self.value
        low, high = np.quantile(known, [0.025, 0.975])
        return self.value, float(low), float(high)

    def ratio(self, other: "Estimate") -> "Estimate":
        """Return this divided by ``other``; NaN where ``other`` is not positive.

        Both must be resampled from one seed: each resample then has the same balls in both, so
        differences between balls cancel.
        """
        value = self.value / other.value if other.value > 0 else np.nan
        positive = np.where(other.resampled > 0, other.resampled, np.nan)
        return Estimate(value, self.resampled / positive)


def resampled_median(
    values: ArrayLike, balls: ArrayLike, count: int, resamples: int, seed: int
) -> Estimate:
    """Return a median over returns, and its values on resamples of the balls.

    Args:
        values: (R,) of returns.
        balls: (R,) the ball that each returned, of 0 ... count - 1. Balls are resampled, not
            returns; a ball brings the returns of all policies, or none.
        count: of the balls.
        resamples: how many.
        seed: of the resamples.
    """
    known = np.asarray(values, dtype=np.float64)
    if not len(known):
        return Estimate(np.nan, np.full(resamples, np.nan))
    counts = resampled_counts(count, resamples, np.random.default_rng(seed))
    owners = np.asarray(balls, dtype=np.int64)
    return Estimate(float(np.median(known)), weighted_medians(known, counts[:, owners]))


def weighted_medians(values: Floats, counts: Integers) -> Floats:
    """Return the (S,) medians of (R,) values repeated (S, R) times; NaN where none is counted."""
    order = np.argsort(values, kind="stable")
    cumulative = np.cumsum(counts[:, order], axis=1)
    total = cumulative[:, -1:]
    lower = (cumulative > (total - 1) // 2).argmax(axis=1)
    upper = (cumulative > total // 2).argmax(axis=1)
    ordered = values[order]
    return np.where(total[:, 0] > 0, (ordered[lower] + ordered[upper]) / 2, np.nan)
