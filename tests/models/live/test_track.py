"""Tracks of balls: what is known of sensor and balls makes forecasts better; histories."""

import numpy as np
import pytest

from rallygap.models.ball.sensor import clock_times, measured
from rallygap.models.live.forecaster import Forecaster
from rallygap.models.live.track import Track, history_of
from rallygap.models.predictors.ball_filter import ANY_BALL, Expected
from tests.models.predictors.balls import TRUTH
from tests.models.predictors.test_sensor import CAMERAS

TIMES = 0.005 * np.arange(100)
SEEN = 25  # samples before the forecast
FIRST = np.array([0.1, 1.2, 0.35, 0.3, -6.0, 1.0, -150.0, 20.0, 30.0])
NONE = np.full(3, np.nan)
BACKSPIN = Expected(spin=(0.0, -150.0, 0.0), spin_spread=(20.0, 20.0, 20.0))


def seen_by_cameras(times=TIMES):
    places, spins = measured(CAMERAS, FIRST, times, np.random.default_rng(0))
    return places[0], spins[0]


def true_places():
    return TRUTH.fly(FIRST, TIMES).states[0, :, :3]


def after_some(places, spins=None, simulator=TRUTH, expected=ANY_BALL, count=SEEN):
    forecaster = Forecaster(simulator, expected=expected)
    for k in range(count):
        forecaster.observe(TIMES[k], places[k], spin=None if spins is None else spins[k])
    return forecaster


def largest_error(forecaster, places):
    states, _ = forecaster.predict(TIMES[60:])
    return np.linalg.norm(states[:, :3] - places[60:], axis=1).max()


def test_forecasts_are_those_of_the_measurements():
    seen = seen_by_cameras()
    assert largest_error(after_some(*seen, CAMERAS), seen[0]) < 0.004
    assert largest_error(after_some(*seen), seen[0]) > 0.02


def test_a_bounce_is_where_and_when_the_cameras_will_see_it():
    contact = TRUTH.fly(FIRST, TIMES).contacts
    event = after_some(*seen_by_cameras(), CAMERAS).bounce()
    assert event.time == pytest.approx(clock_times(CAMERAS, contact.time[0, 0]), abs=5e-4)
    there, _ = seen_by_cameras(np.array([event.time]))
    assert event.state[:3] == pytest.approx(there[0], abs=0.004)


def test_measurements_are_kept_as_they_were_measured():
    places, spins = seen_by_cameras()
    ball = after_some(places, spins, CAMERAS).ball
    assert (ball.positions == places[:SEEN]).all()
    assert (ball.spins == spins[:SEEN]).all()
    assert (ball.times == TIMES[:SEEN]).all()


def test_a_ball_without_a_label_has_the_expected_spin():
    places = true_places()
    known, any_ball = (
        largest_error(after_some(places, expected=one), places) for one in (BACKSPIN, ANY_BALL)
    )
    assert known < 0.6 * any_ball
    # Also if a measurement comes late.
    forecaster = Forecaster(TRUTH, expected=BACKSPIN)
    for k in (0, 1, 3, 4, 5, 2, 6, 7, 8, 9):
        forecaster.observe(TIMES[k], places[k])
    in_time = after_some(places, expected=BACKSPIN, count=10)
    np.testing.assert_allclose(forecaster.ball.state, in_time.ball.state, rtol=1e-9)


def history(times, labelled=()):
    """The history of a ball that was measured at some times, at some of them with a label."""
    track = Track(TRUTH)
    for k, (t, state) in enumerate(zip(times, TRUTH.fly(FIRST, times).states[0], strict=True)):
        assert track.add(t, state[:3], 1e-6 * np.eye(3), FIRST[6:] if k in labelled else NONE)
    return history_of(track)


def test_a_history_is_what_a_predictor_would_have_read_from_a_recording():
    times = TIMES[:20]
    found = history(times, labelled=(10, 19))
    assert found.mask[..., :3].all()
    expected = true_places()[8:20]
    assert found.states[0, :, :3] == pytest.approx(expected, abs=1e-9)
    assert np.flatnonzero(found.mask[0, :, 3]).tolist() == [2, 11]
    assert found.states[0, 2, 3:] == pytest.approx(FIRST[6:])
    times = np.arange(0.0, 0.1, 0.0077)  # positions are interpolated
    grid = times[-1] + 0.005 * np.arange(-11, 1)
    found = history(times)
    assert found.mask[..., :3].all()
    expected = TRUTH.fly(FIRST, grid).states[0, :, :3]
    assert found.states[0, :, :3] == pytest.approx(expected, abs=1e-3)


def test_long_gaps_and_what_was_before_the_first_measurement_are_not_measured():
    times = 0.005 * np.r_[0:4, 8:11]
    measured = np.flatnonzero(history(times).mask[0, :, 0]).tolist()
    assert measured == [1, 2, 3, 4, 9, 10, 11]
    assert np.flatnonzero(history(times[:1]).mask[0, :, 0]).tolist() == [11]
