"""Mixture of readings: labels as read, negated, or outliers, by the spins that paths tell.

Less the spin, a label is normal if it is as read; so is its sum with the spin if it is negated. The
variance is that of the path's spin and of the label, which has a share of the spin and a constant
part. The latter also covers what the simulator's misfit adds to spins by paths, so that it does
not pass for negated labels. A gain of the paths' spins covers a lift coefficient that is wrong:
paths show its product with the spin. Outliers are independent of the spin. Gain, errors and the
shares of the readings are the maximum-likelihood ones (a grid, and expectation maximisation).
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.special import logsumexp

from rallygap.models.ball.types import Floats
from rallygap.models.gap.name.path_spins import PathSpins

AS_READ, NEGATED, OUTLIER = range(3)
GAINS = np.geomspace(0.25, 4.0, 13)  # of spins by paths
SHARES_OF_SPIN = np.geomspace(0.03, 1.0, 9)  # label errors
SHARES_OF_TYPICAL = np.append(0.0, np.geomspace(0.05, 2.0, 8))  # their constant part
OUTLIERS = 3.0  # typical labels, the size of outliers
ROUNDS = 15  # of expectation maximisation
LEAST_SHARE = 1e-3  # of a reading
LEAST_VARIANCE = 1e-6  # (rad/s)^2, where all labels are zero


@dataclass(frozen=True)
class ReadingMixture:
    """The maximum-likelihood mixture of S labels.

    Attributes:
        densities: (S, 3) logarithms of the densities of a label by its readings.
        shares: (3,) of the readings.
    """

    densities: Floats
    shares: Floats

    @classmethod
    def of(cls, found: PathSpins) -> "ReadingMixture":
        """Return the maximum-likelihood mixture of at least one label."""
        densities = _densities(found)
        shares = np.full((len(densities), 3), 1 / 3)
        for _ in range(ROUNDS):
            joint = densities + np.log(shares)[:, None]
            posterior = np.exp(joint - logsumexp(joint, axis=2, keepdims=True))
            shares = np.maximum(posterior.mean(axis=1), LEAST_SHARE)
            shares /= shares.sum(axis=1, keepdims=True)
        likelihoods = logsumexp(densities + np.log(shares)[:, None], axis=2).sum(axis=1)
        best = int(np.argmax(likelihoods))
        return cls(densities[best], shares[best])

    def readings(self, least: float) -> NDArray[np.int64]:
        """Return (S,) the most probable readings.

        A negated label must be ``least`` more likely so than as read, in twice the log likelihood.
        If it is not, it is of no use, as an outlier.
        """
        likeliest = np.argmax(self.densities + np.log(self.shares), axis=1)
        gains = 2 * (self.densities[:, NEGATED] - self.densities[:, AS_READ])
        return np.where((likeliest == NEGATED) & (gains <= least), OUTLIER, likeliest)


def _densities(found: PathSpins) -> Floats:
    """Return (G, S, 3) logarithms of the densities of labels by sizes of errors and readings."""
    grids = np.meshgrid(GAINS, SHARES_OF_SPIN, SHARES_OF_TYPICAL, indexing="ij")
    gains, shares, constants = (grid.reshape(-1, 1) for grid in grids)
    squares = (found.spins**2).sum(axis=1)
    typical = np.median((found.labels**2).sum(axis=1))
    of_labels = ((shares * gains) ** 2 * squares + constants**2 * typical) / 3
    of_paths, axes = np.linalg.eigh(found.covariance)
    variances = of_labels[..., None] + gains[..., None] ** 2 * np.maximum(of_paths, 0.0)
    labels, spins = (np.einsum("sij,si->sj", axes, rows) for rows in (found.labels, found.spins))
    spins = gains[..., None] * spins
    spread = np.full_like(variances, OUTLIERS**2 * typical / 3)
    rows = (labels - spins, variances), (labels + spins, variances), (labels + 0 * spins, spread)
    return np.stack([_normal(*one) for one in rows], axis=-1)


def _normal(rows: Floats, variances: Floats) -> Floats:
    """Return (G, S) logarithms of normal densities of (S, 3) rows, less a constant."""
    variances = np.maximum(variances, LEAST_VARIANCE)
    terms: Floats = -0.5 * (rows**2 / variances + np.log(variances))
    return np.asarray(terms.sum(axis=-1))
