"""The smoother against the batch solution of the same linear problem."""

import numpy as np

from rallygap.models.segmentation import flight
from rallygap.models.segmentation.smoothing import smooth

NOISE = 0.003


def batch(t, z, used):
    """Return the most probable states of a drag-free axis, all samples at once."""
    n = len(t)
    whiten, aims = [], []

    def add(columns, covariance, aim):
        row = np.zeros((3, 3 * n))
        for k, block in columns:
            row[:, 3 * k : 3 * k + 3] = block
        root = np.linalg.inv(np.linalg.cholesky(covariance))
        whiten.append(root @ row)
        aims.append(root @ aim)

    mean, covariance = np.empty((3, 3)), np.empty((3, 3))
    flight.initialise(mean, covariance, np.array([0.0, 0.0, z[0]]), NOISE)
    add([(0, np.eye(3))], covariance, mean[:, 2])
    for k in range(1, n):
        jerk = np.zeros((3, 3))
        flight.predict_covariance(jerk, t[k] - t[k - 1])
        step = flight.transition(t[k] - t[k - 1])
        add([(k - 1, -step), (k, np.eye(3))], jerk, np.zeros(3))
        if used[k]:
            whiten.append(np.eye(3 * n)[3 * k][None] / NOISE)
            aims.append(np.array([z[k] / NOISE]))
    return np.linalg.lstsq(np.concatenate(whiten), np.concatenate(aims))[0].reshape(n, 3)


def test_smoothed_states_are_the_most_probable_ones():
    rng = np.random.default_rng(2)
    t = np.cumsum(rng.uniform(0.004, 0.006, 12))
    # Dropped, and so slow that drag, the one nonlinear term, is next to nothing.
    z = -4.905 * (t - t[0]) ** 2 + rng.normal(0, NOISE, 12)
    used = np.arange(12) != 5
    means = smooth(t, np.stack([0 * t, 0 * t, z], axis=1), used, NOISE)
    expected = batch(t, z, used)
    np.testing.assert_allclose(means[:, 0, 2], expected[:, 0], atol=1e-4)
    np.testing.assert_allclose(means[:, 1, 2], expected[:, 1], atol=5e-3)
