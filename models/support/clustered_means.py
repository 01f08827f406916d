"""Means over trainings and recordings, with intervals for both together.

Trainings differ only in the seed, and shots of a recording share players and cameras. Both are
sources of variance. With three trainings a bootstrap that draws them stays between the worst and
the best one, so it covers too seldom. Here the variances of both clusterings are added, less that
of their intersection (Cameron, Gelbach and Miller 2011), with Satterthwaite's (1946) degrees of
freedom.
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.stats import t as student

Floats = NDArray[np.float64]
CONFIDENCE = 0.95


@dataclass(frozen=True)
class ClusteredMean:
    """Means of K quantities.

    Attributes:
        mean: (K,).
        low: (K,) lower ends of their 95 % intervals.
        high: (K,) upper ends.
        p: (K,) two-sided p-values that they differ from zero.
    """

    mean: Floats
    low: Floats
    high: Floats
    p: Floats


def clustered_mean(values: Floats, recordings: NDArray[np.generic]) -> ClusteredMean:
    """Return means with intervals over trainings and recordings.

    Args:
        values: (D, B, K) K quantities of B shots in each of D trainings; NaN where there is none.
        recordings: (B,) that shots are from.
    """
    counted = np.isfinite(values)
    count = counted.sum(axis=(0, 1))
    mean = np.where(counted, values, 0.0).sum(axis=(0, 1)) / count
    influence = np.where(counted, values - mean, 0.0) / count
    names, member = np.unique(recordings, return_inverse=True)
    belongs = (member == np.arange(len(names))[:, None]).astype(np.float64)
    error, freedom = _standard_error(belongs @ influence)  # summed over each recording's shots
    margin = error * student.ppf(0.5 + CONFIDENCE / 2, freedom)
    with np.errstate(divide="ignore", invalid="ignore"):
        p = 2 * student.sf(np.abs(mean) / error, freedom)
    return ClusteredMean(mean, mean - margin, mean + margin, np.where(mean == 0, 1.0, p))


def _standard_error(sums: Floats) -> tuple[Floats, Floats]:
    """Return the (K,) standard errors of means and their degrees of freedom.

    Args:
        sums: (D, R, K) influence on the means, by training and recording.
    """
    trainings, recordings, size = sums.shape
    by_training, by_recording = _variance(sums.sum(axis=1)), _variance(sums.sum(axis=0))
    by_both = _variance(sums.reshape(-1, size))
    between = np.maximum(by_training - by_both, 0.0)  # what trainings vary beyond their shots
    variance = by_recording + between
    parts = by_recording**2 / max(recordings - 1, 1) + between**2 / max(trainings - 1, 1)
    certain = variance == 0
    freedom = np.where(certain, 1.0, variance**2 / np.where(certain, 1.0, parts))
    return np.sqrt(variance), freedom


def _variance(sums: Floats) -> Floats:
    """Return the (K,) variances of means, from the (C, K) influences of independent clusters."""
    clusters = len(sums)
    if clusters == 1:
        return np.zeros(sums.shape[1])
    return clusters / (clusters - 1) * (sums**2).sum(axis=0)
