"""Forecast protocols: the right instants, and no error but the forecaster's."""

import numpy as np
import pytest

from models.policy.forecasts import every_tick, exact, first_state, first_window, re_anchored
from models.policy.incoming import FIRST_WINDOW, fly_in, tick_times
from models.policy.measurements import Measurements, measure
from models.policy.settings import SensorNoise
from models.predictors.physics import PhysicsPredictor
from models.predictors.protocol import FUTURE_TIMES, Forecast
from tests.models.policy.incoming_balls import (
    HORIZONS,
    THROWN,
    TRUTH,
    VACUUM,
    WRONG,
    parabola,
    struck,
)

CLEAN = SensorNoise(position=0.0, spin=0.0)
NOISY = SensorNoise(position=0.003, spin=0.05)


class Numbers:
    """A predictor that numbers the states: 1000 times the last measured x, plus how far ahead."""

    def predict(self, history):
        last = history.states[:, -1, 0]
        states = 1000 * last[:, None, None] + np.arange(1, 61)[:, None] + np.zeros((1, 1, 9))
        return Forecast(states, np.zeros(len(last), dtype=bool))


def measured(path, playable, noise):
    return measure(path, playable[:, 1], noise, np.random.default_rng(0))


def position_errors(forecasts, path, playable):
    """Errors at the middle horizon, at ticks at which the ball is not gone by then."""
    live = tick_times(FIRST_WINDOW) + HORIZONS[1] / 1000 < playable[:, 1:]
    error = (forecasts - exact(path, HORIZONS, FIRST_WINDOW))[:, :, 1, :3]
    return np.linalg.norm(error, axis=2)[live]


def test_a_parabola_is_forecast_at_its_ticks_and_horizons():
    path, _ = fly_in(VACUUM, THROWN)
    expected = parabola(tick_times(0.0)[:, None] + np.array(HORIZONS) / 1000)
    for forecasts in (
        exact(path, HORIZONS),
        first_state(VACUUM, THROWN, HORIZONS),
        re_anchored(VACUUM, path, HORIZONS),
    ):
        np.testing.assert_allclose(forecasts, expected[None], atol=1e-8)


def test_a_measured_parabola_is_forecast_at_its_ticks_and_horizons():
    path, _ = fly_in(VACUUM, THROWN)
    seen = measure(path, np.array([np.inf]), CLEAN, np.random.default_rng(0))
    expected = parabola(tick_times(FIRST_WINDOW)[:, None] + np.array(HORIZONS) / 1000)
    np.testing.assert_allclose(exact(path, HORIZONS, FIRST_WINDOW)[0], expected, atol=1e-8)
    np.testing.assert_allclose(first_window(VACUUM, seen, HORIZONS)[0], expected, atol=1e-3)
    every = every_tick(PhysicsPredictor(VACUUM), seen, HORIZONS)
    np.testing.assert_allclose(every[0], expected, atol=1e-3)


def test_the_true_simulator_forecasts_the_truth():
    launches, path, _ = struck()
    truth = exact(path, HORIZONS)
    np.testing.assert_allclose(re_anchored(TRUTH, path, HORIZONS), truth, atol=1e-5)
    np.testing.assert_allclose(first_state(TRUTH, launches, HORIZONS), truth, atol=1e-5)


def test_a_wrong_simulator_errs_along_the_flight_unless_it_is_anchored_anew():
    launches, path, playable = struck()
    live = tick_times(0.0) < playable[:, 1:] - 0.2
    truth = exact(path, HORIZONS)
    first = np.linalg.norm((first_state(WRONG, launches, HORIZONS) - truth)[..., 1, :3], axis=2)
    anew = np.linalg.norm((re_anchored(WRONG, path, HORIZONS) - truth)[..., 1, :3], axis=2)
    assert 0.002 < anew[live].mean() < 0.02 < 0.05 < first[live].mean()
    np.testing.assert_allclose(first[:, 0], anew[:, 0], atol=1e-9)


def test_true_physics_on_clean_measurements_is_close_to_the_truth():
    _, path, playable = struck()
    seen = measured(path, playable, CLEAN)
    every = position_errors(every_tick(PhysicsPredictor(TRUTH), seen, HORIZONS), path, playable)
    first = position_errors(first_window(TRUTH, seen, HORIZONS), path, playable)
    assert np.median(every) < 1e-4 and np.percentile(every, 99) < 0.01
    assert np.median(first) < 1e-3 and np.percentile(first, 99) < 0.05


def test_measuring_anew_at_every_tick_helps_where_measurements_are_noisy():
    _, path, playable = struck()
    seen = measured(path, playable, NOISY)
    every = position_errors(every_tick(PhysicsPredictor(TRUTH), seen, HORIZONS), path, playable)
    first = position_errors(first_window(TRUTH, seen, HORIZONS), path, playable)
    assert 0.003 < every.mean() < 0.02 < first.mean() < 0.1


@pytest.mark.parametrize("count", [27, 28])
def test_a_lost_ball_is_forecast_further_ahead_until_the_forecast_ends(count):
    states = np.arange(1.0, 282.0)[None, :, None] * np.ones(6)
    mask = np.arange(281)[None, :, None] + np.zeros(6) < count
    seen = Measurements(np.where(mask, states, 0.0), mask)
    told = every_tick(Numbers(), seen, HORIZONS)[0, :, 0, 0]
    last = 12 + 8 * ((count - 12) // 8)
    sooner = [1000.0 * end + 23 for end in range(12, last + 1, 8)]
    later = [1000.0 * last + min(23 + 8 * k, 60) for k in range(1, 35 - len(sooner))]
    np.testing.assert_array_equal(told, sooner + later)
    assert FUTURE_TIMES[22] == pytest.approx(HORIZONS[0] / 1000)
