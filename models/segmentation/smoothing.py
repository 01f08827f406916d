"""Rauch-Tung-Striebel smoother of one arc."""

import numpy as np

from rallygap.models.ball.types import Bools, Floats
from rallygap.models.segmentation.flight import (
    compiled,
    initialise,
    predict_covariance,
    predict_mean,
    transition,
    update,
)


@compiled
def smooth(t: Floats, x: Floats, used: Bools, noise: float) -> Floats:
    """Return the smoothed means at all samples, given the used ones.

    Args:
        t: increasing times (n,), s.
        x: positions (n, 3), m.
        used: whether a sample (n,) is used; the first one must be.
        noise: standard deviation of a sample in each axis, m.

    Returns:
        Means (n, 3, 3): rows position, velocity, unexplained acceleration.
    """
    n = len(t)
    means, covariances = np.empty((n, 3, 3)), np.empty((n, 3, 3))
    predicted, predicted_covariances = np.empty((n, 3, 3)), np.empty((n, 3, 3))
    initialise(means[0], covariances[0], x[0], noise)
    for k in range(1, n):
        predicted[k], predicted_covariances[k] = means[k - 1], covariances[k - 1]
        predict_mean(predicted[k], t[k] - t[k - 1])
        predict_covariance(predicted_covariances[k], t[k] - t[k - 1])
        means[k], covariances[k] = predicted[k], predicted_covariances[k]
        if used[k]:
            update(means[k], covariances[k], x[k], noise)
    for k in range(n - 2, -1, -1):
        forward = transition(t[k + 1] - t[k])
        gain = np.linalg.solve(predicted_covariances[k + 1], forward @ covariances[k]).T
        means[k] += gain @ (means[k + 1] - predicted[k + 1])
    return means
