"""Smooth error of measured positions over space: the covariance of a Gaussian field."""

import numpy as np
from scipy.spatial.distance import cdist

from rallygap.models.ball.types import Floats

BLOCK = 2048  # places at once, so that their covariances stay in the processor's cache


def covariance(positions: Floats, others: Floats, length: float) -> Floats:
    """Return (N, M) covariances of a field of unit variance at (N, 3) and (M, 3) places, m.

    The covariance is a squared exponential: two places ``length`` apart have the correlation
    exp(-1/2).
    """
    exponents = cdist(positions, others, "sqeuclidean")
    exponents *= -0.5 / length**2
    return np.asarray(np.exp(exponents, out=exponents))


def weighted_covariances(
    positions: Floats, nodes: Floats, weights: Floats, length: float
) -> Floats:
    """Return (N, D) sums of covariances of (N, 3) places with (M, 3) nodes, by (M, D) weights."""
    sums = np.empty((len(positions), weights.shape[1]))
    for first in range(0, len(positions), BLOCK):
        rows = slice(first, first + BLOCK)
        sums[rows] = covariance(positions[rows], nodes, length) @ weights
    return sums
