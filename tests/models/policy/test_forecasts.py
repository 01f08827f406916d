"""Forecast protocols: the right instants, and no error but the forecaster's."""

import numpy as np
import pytest

from rallygap.models.policy.forecasts import exact, first_state, forecast_error, re_anchored
from rallygap.models.policy.incoming_balls import IncomingBalls, control_times, fly_incoming
from tests.models.policy.incoming_balls import (
    HORIZONS,
    THROWN,
    TRUTH,
    VACUUM,
    WRONG,
    parabola,
    struck,
)


def test_a_parabola_is_forecast_at_its_ticks_and_horizons():
    path, _ = fly_incoming(VACUUM, THROWN)
    expected = parabola(control_times(0.0)[:, None] + np.array(HORIZONS) / 1000)
    for forecasts in (
        exact(path, HORIZONS),
        first_state(VACUUM, THROWN, HORIZONS),
        re_anchored(VACUUM, path, HORIZONS),
    ):
        np.testing.assert_allclose(forecasts, expected[None], atol=1e-8)


def test_the_true_simulator_forecasts_the_truth():
    launches, path, _ = struck()
    truth = exact(path, HORIZONS)
    np.testing.assert_allclose(re_anchored(TRUTH, path, HORIZONS), truth, atol=1e-5)
    np.testing.assert_allclose(first_state(TRUTH, launches, HORIZONS), truth, atol=1e-5)


def test_a_wrong_simulator_errs_along_the_flight_unless_it_is_re_anchored():
    launches, path, playable = struck()
    live = control_times(0.0) < playable[:, 1:] - 0.2
    truth = exact(path, HORIZONS)
    first = np.linalg.norm((first_state(WRONG, launches, HORIZONS) - truth)[..., 1, :3], axis=2)
    again = np.linalg.norm((re_anchored(WRONG, path, HORIZONS) - truth)[..., 1, :3], axis=2)
    assert 0.002 < again[live].mean() < 0.02 < 0.05 < first[live].mean()
    np.testing.assert_allclose(first[:, 0], again[:, 0], atol=1e-9)


def test_the_forecast_error_counts_until_the_ball_is_gone():
    _, path, playable = struck()
    forecasts = exact(path, HORIZONS)
    forecasts[..., 1, 0] += 0.03
    forecasts[..., [0, 2], 0] += 0.5  # other horizons
    forecasts[control_times(0.0) >= playable[:, 1:]] += 7.0

    incoming = IncomingBalls(path, playable, 0.0, forecasts)

    assert forecast_error(incoming, HORIZONS) == pytest.approx(0.03)
