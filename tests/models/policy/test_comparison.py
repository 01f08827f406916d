"""Comparison: pairs of the same balls, resampled ball by ball; forecasts measured as they fly."""

import numpy as np
import pytest

from models.policy.comparison import compare, forecast_error, intervals
from models.policy.forecasts import exact
from models.policy.incoming_balls import IncomingBalls, control_times
from tests.models.policy.incoming_balls import HORIZONS, struck

RESAMPLES = 4000


def outcomes(share, policies=1, balls=400, seed=0):
    """Return (R, B, 1): there is one way to succeed."""
    return np.random.default_rng(seed).random((policies, balls, 1)) < share


def test_difference_and_discordant_balls_by_hand():
    one = np.array([[1, 1, 1, 0], [1, 1, 0, 0]], dtype=bool)
    other = np.array([[1, 0, 0, 1], [1, 0, 1, 0]], dtype=bool)

    forth, back = compare(np.dstack([one, other]), np.dstack([other, one]), RESAMPLES, 0)

    assert forth.difference.mean == 1 / 8
    assert (forth.gained, forth.lost) == (1, 1)  # the third ball counts once each way
    assert back.difference.mean == -1 / 8


def test_what_is_the_same_differs_by_exactly_nothing():
    same = outcomes(0.9, policies=2)

    (compared,) = compare(same, same, RESAMPLES, 0)

    assert vars(compared.difference) == {"mean": 0.0, "low": 0.0, "high": 0.0}
    assert compared.gained == compared.lost == 0


def test_the_interval_is_that_of_paired_balls():
    one, other = outcomes(0.8, balls=900), outcomes(0.7, balls=900, seed=1)
    other[:, 450:] = one[:, 450:]  # half of the balls end alike

    found = compare(one, other, RESAMPLES, 0)[0].difference

    margin = 1.96 * np.std(one.astype(float) - other) / np.sqrt(900)
    assert found.high - found.mean == pytest.approx(margin, rel=0.1)
    assert found.mean - found.low == pytest.approx(margin, rel=0.1)


def test_a_second_policy_that_does_the_same_makes_nothing_surer():
    single = outcomes(0.8).astype(float)

    double = np.tile(single, (2, 1, 1))

    assert intervals(double, RESAMPLES, 0) == intervals(single, RESAMPLES, 0)


def test_forecasts_count_until_the_ball_is_gone():
    _, path, playable = struck()
    forecasts = exact(path, HORIZONS)
    forecasts[..., 1, 0] += 0.03
    forecasts[..., [0, 2], 0] += 0.5  # other horizons
    forecasts[control_times(0.0) >= playable[:, 1:]] += 7.0

    told = IncomingBalls(path, playable, 0.0, forecasts)

    assert forecast_error(told, HORIZONS) == pytest.approx(0.03)
