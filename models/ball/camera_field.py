"""Smooth error of measured positions over space: the covariance of a Gaussian field."""

import numpy as np
from scipy.spatial.distance import cdist

from models.ball.types import Floats


def covariance(places: Floats, others: Floats, length: float) -> Floats:
    """Return (N, M) covariances of a field of unit variance at (N, 3) and (M, 3) places, m.

    The covariance is a squared exponential: two places ``length`` apart have the correlation
    exp(-1/2).
    """
    correlation: Floats = np.exp(-0.5 * cdist(places, others, "sqeuclidean") / length**2)
    return correlation
