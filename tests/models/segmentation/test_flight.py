"""The flight filter and smoother against textbook formulas and independent solutions."""

import numpy as np
import pytest
from scipy.integrate import quad_vec, solve_ivp

from rallygap.models.segmentation.flight import (
    DRAG,
    JERK_DENSITY,
    initialise,
    predict_covariance,
    predict_mean,
    smooth,
    transition,
    update,
)

MEAN = np.array([[0.1, -1.0, 0.3], [1.0, 9.0, 2.0], [0.5, -1.0, -9.0]])
NOISE = 0.003


@pytest.mark.parametrize("dt", [0.005, -0.005])
def test_predicted_mean_follows_a_ball_with_drag(dt):
    def motion(_, state):
        return [*state[3:], *(MEAN[2] - DRAG * np.linalg.norm(state[3:]) * state[3:])]

    exact = solve_ivp(motion, (0, dt), MEAN[:2].ravel(), rtol=1e-10, atol=1e-12).y[:, -1]
    mean = MEAN.copy()
    predict_mean(mean, dt)
    np.testing.assert_allclose(mean[0], exact[:3], atol=1e-6)
    np.testing.assert_allclose(mean[1], exact[3:], atol=1e-3)


def test_prediction_adds_the_integral_of_white_jerk_and_update_is_that_of_kalman():
    rng = np.random.default_rng(4)
    root, sample = rng.normal(size=(3, 3)), rng.normal(size=3)
    dt, jerk = 0.03, np.array([0.0, 0.0, 1.0])
    grown = quad_vec(lambda s: np.outer(transition(s) @ jerk, transition(s) @ jerk), 0, dt)[0]
    expected = transition(dt) @ root @ root.T @ transition(dt).T + JERK_DENSITY * grown
    mean, covariance = MEAN.copy(), root @ root.T
    predict_covariance(covariance, dt)
    np.testing.assert_allclose(covariance, expected, rtol=1e-12)

    observed = np.array([[1.0, 0.0, 0.0]])
    gain = covariance @ observed.T / (covariance[0, 0] + NOISE**2)
    expected = MEAN + gain * (sample - MEAN[0]), (np.eye(3) - gain @ observed) @ covariance
    update(mean, covariance, sample, NOISE)
    np.testing.assert_allclose(mean, expected[0], rtol=1e-12)
    np.testing.assert_allclose(covariance, expected[1], rtol=1e-9, atol=1e-12)


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
    initialise(mean, covariance, np.array([0.0, 0.0, z[0]]), NOISE)
    add([(0, np.eye(3))], covariance, mean[:, 2])
    for k in range(1, n):
        jerk = np.zeros((3, 3))
        predict_covariance(jerk, t[k] - t[k - 1])
        step = transition(t[k] - t[k - 1])
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
