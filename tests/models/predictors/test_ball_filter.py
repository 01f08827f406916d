"""The compiled ball filter agrees with filterpy's; what it is unsure of spreads as balls do."""

import numpy as np
import pytest

from rallygap.models.ball.simulator import Simulator
from rallygap.models.predictors.ball_filter import Expected, filtered
from rallygap.models.predictors.filterpy_ekf import FilterpyPredictor, filtered_by_filterpy
from rallygap.models.predictors.physics import PhysicsPredictor
from rallygap.models.predictors.propagation import propagated
from rallygap.models.predictors.protocol import History
from tests.models.predictors.balls import FIRST, TRUTH, observed

BALLS = np.tile(FIRST, (4, 1))


def with_gaps_and_outliers(history, seed):
    random = np.random.default_rng(seed)
    states, mask = history.states.copy(), history.mask.copy()
    struck = random.random(states.shape[:2]) < 0.1
    states[struck, :3] += random.normal(size=(struck.sum(), 3)) * 0.2
    mask[random.random(states.shape[:2]) < 0.15, :3] = False
    mask[random.random(states.shape[:2]) < 0.3, 3:] = False
    mask[0] = False
    return History(np.where(mask, states, 0.0), mask)


@pytest.mark.parametrize("labelled", [True, False])
@pytest.mark.parametrize("spoilt", [True, False])
def test_states_and_covariances_are_those_of_filterpy(labelled, spoilt):
    history, _ = observed(BALLS, noise=0.003, labelled=labelled)
    if spoilt:
        history = with_gaps_and_outliers(history, seed=3)
    compiled, reference = filtered(history, TRUTH), filtered_by_filterpy(history, TRUTH)
    assert compiled.states == pytest.approx(reference.states, rel=1e-6, abs=1e-5)
    assert compiled.covariances == pytest.approx(reference.covariances, rel=1e-5, abs=1e-7)


def test_both_forecast_the_same_where_the_sensor_errs_too():
    sensor = TRUTH.amended("clock_rate", d=0.02).amended("position_scale", s=0.01)
    history, _ = observed(BALLS, noise=0.003)
    forecasts = [one(sensor).predict(history) for one in (PhysicsPredictor, FilterpyPredictor)]
    assert forecasts[0].states == pytest.approx(forecasts[1].states, rel=1e-6, abs=1e-5)


def test_errors_are_as_large_as_the_covariance_says():
    """The mean of the squared Mahalanobis distances of many balls is the number of components."""
    balls = np.tile(FIRST[0], (300, 1))
    history, _ = observed(balls, noise=0.004, labelled=False)
    found = filtered(history, TRUTH)
    true = TRUTH.fly(balls[:1], [11 * 0.005]).states[0, 0]
    miss = (found.states - true)[:, :6]
    inner = found.covariances[:, :6, :6]
    distances = np.einsum("bi,bi->b", miss, np.linalg.solve(inner, miss[..., None])[..., 0])
    assert distances.mean() == pytest.approx(6.0, rel=0.3)


def test_the_expected_spin_turns_with_the_course():
    """Topspin of 200 rad/s, whichever way a ball flies."""
    topspin = Expected(spin=(0.0, 200.0, 0.0), spin_spread=(1.0, 1.0, 1.0))
    courses = np.array([[5.0, 0.0, 1.0], [0.0, -5.0, 1.0]])
    history, _ = observed(np.hstack([[[0, 0, 0.4]] * 2, courses, np.zeros((2, 3))]), labelled=False)
    spins = filtered(history, TRUTH, topspin).states[:, 6:]
    np.testing.assert_allclose(spins, [[0.0, 200.0, 0.0], [200.0, 0.0, 0.0]], atol=10.0)


STATE = np.array([0.1, 1.2, 0.35, 0.3, -6.0, 1.0, -150.0, 20.0, 30.0])
SPREAD = np.diag(np.repeat([0.002, 0.1, 20.0], 3) ** 2)
AHEAD = np.array([0.1, 0.2, 0.3, 0.6])  # the last one after a bounce


def test_covariances_are_those_of_many_balls():
    balls = np.random.default_rng(0).multivariate_normal(STATE, SPREAD, 2000)
    flown = TRUTH.fly(balls, AHEAD).states
    _, found = propagated(TRUTH, STATE[None], SPREAD[None], AHEAD)
    _, none = propagated(TRUTH, STATE[None], 0 * SPREAD[None], AHEAD)
    for k in range(len(AHEAD)):
        size = np.sqrt(np.diag(np.cov(flown[:, k].T)))
        assert np.sqrt(np.diag((found - none)[0, k])) == pytest.approx(size, rel=0.1, abs=1e-3)


def test_process_noise_grows_as_the_filters_does():
    """In a vacuum, as the sum of the ticks' noise carried on at constant velocity."""
    vacuum = Simulator.from_dict({"gravity": {"g": 9.81}})
    _, found = propagated(vacuum, STATE[None], 0 * SPREAD[None], np.array([0.3]))
    ticks, lever = 60, 0.005 * (np.arange(60) + 0.5)
    assert found[0, 0, 3, 3] == pytest.approx(ticks * (2.0 * 0.005) ** 2)
    assert found[0, 0, 0, 0] == pytest.approx(((2.0 * 0.005 * lever) ** 2).sum(), rel=1e-3)
    assert found[0, 0, 6, 6] == pytest.approx(ticks)
