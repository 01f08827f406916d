"""The flight filter and smoother against textbook formulas, and the partition into arcs."""

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
from rallygap.models.segmentation.partition import FEWEST_SAMPLES, partition

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


COST = 16.0  # of a contact, and of an outlier
STEP = 0.005


def arcs(t, x):
    first, _, last = partition(t, x, NOISE, COST, COST)
    return list(zip(first.tolist(), last.tolist(), strict=True))


def path(samples, velocity, begin=(0.0, 0.0, 0.3)):
    t = STEP * np.arange(samples)[:, None]
    return np.array(begin) + t * velocity + 0.5 * t**2 * [0, 0, -9.81]


def noisy(x, seed):
    return x + np.random.default_rng(seed).normal(0, NOISE, x.shape)


def clock(x):
    return STEP * np.arange(len(x))


@pytest.mark.parametrize("seed", range(10))
def test_noise_and_outliers_do_not_break_an_arc(seed):
    x = noisy(path(80, [0.5, 4.0, 2.0]), seed)
    assert arcs(clock(x), x) == [(0, 79)]
    random = np.random.default_rng(100 + seed)
    off = random.choice(np.arange(1, 79), 8, replace=False)
    x[off] += random.choice([-1, 1], (8, 3)) * random.uniform(0.05, 0.5, (8, 3))
    assert arcs(clock(x), x) == [(0, 79)]


@pytest.mark.parametrize("between", [FEWEST_SAMPLES, 4, 5])
def test_few_samples_between_two_contacts_are_an_arc(between):
    down = path(20, [0.0, -5.0, -2.0])
    up = path(between + 1, [0.0, -4.5, 3.0], down[-1])[1:]
    back = path(20, [1.0, 8.0, 2.0], up[-1])[1:]
    x = noisy(np.concatenate([down, up, back]), 1)
    breaks = [first for first, _ in arcs(clock(x), x)[1:]]
    np.testing.assert_allclose(breaks, [20, 20 + between], atol=1)
    assert len(breaks) == 2


def test_random_samples_are_in_no_arc():
    x = np.random.default_rng(3).uniform(-2, 2, (30, 3))
    assert arcs(clock(x), x) == []
