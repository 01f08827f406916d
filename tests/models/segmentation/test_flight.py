"""The flight filter against textbook formulas and an independent integrator."""

import numpy as np
import pytest
from scipy.integrate import quad_vec, solve_ivp

from rallygap.models.segmentation.flight import (
    DRAG,
    JERK_DENSITY,
    negative_log_likelihood,
    predict_covariance,
    predict_mean,
    transition,
    update,
)

MEAN = np.array([[0.1, -1.0, 0.3], [1.0, 9.0, 2.0], [0.5, -1.0, -9.0]])
NOISE = 0.003


@pytest.fixture
def covariance(rng):
    root = rng.normal(size=(3, 3))
    return root @ root.T


@pytest.fixture
def rng():
    return np.random.default_rng(4)


@pytest.mark.parametrize("dt", [0.005, -0.005])
def test_predicted_mean_follows_a_ball_with_drag(dt):
    def motion(_, state):
        return [*state[3:], *(MEAN[2] - DRAG * np.linalg.norm(state[3:]) * state[3:])]

    exact = solve_ivp(motion, (0, dt), MEAN[:2].ravel(), rtol=1e-10, atol=1e-12).y[:, -1]
    mean = MEAN.copy()
    predict_mean(mean, dt)
    np.testing.assert_allclose(mean[0], exact[:3], atol=1e-6)
    np.testing.assert_allclose(mean[1], exact[3:], atol=1e-3)


def test_predicted_covariance_adds_the_integral_of_white_jerk(covariance):
    dt, jerk = 0.03, np.array([0.0, 0.0, 1.0])
    grown = quad_vec(lambda s: np.outer(transition(s) @ jerk, transition(s) @ jerk), 0, dt)[0]
    expected = transition(dt) @ covariance @ transition(dt).T + JERK_DENSITY * grown
    predict_covariance(covariance, dt)
    np.testing.assert_allclose(covariance, expected, rtol=1e-12)


def test_update_is_the_kalman_update(covariance, rng):
    mean, sample = MEAN.copy(), rng.normal(size=3)
    observed = np.array([[1.0, 0.0, 0.0]])
    gain = covariance @ observed.T / (covariance[0, 0] + NOISE**2)
    expected = MEAN + gain * (sample - MEAN[0]), (np.eye(3) - gain @ observed) @ covariance
    update(mean, covariance, sample, NOISE)
    np.testing.assert_allclose(mean, expected[0], rtol=1e-12)
    np.testing.assert_allclose(covariance, expected[1], rtol=1e-9, atol=1e-12)


def test_negative_log_likelihood_is_zero_for_a_certain_prediction_and_grows_with_the_error():
    sample = np.zeros(3)
    mean, covariance = np.zeros((3, 3)), np.zeros((3, 3))
    assert negative_log_likelihood(mean, covariance, sample, NOISE) == 0
    mean[0] = [0, 0, 4 * NOISE]
    assert negative_log_likelihood(mean, covariance, sample, NOISE) == pytest.approx(8)
