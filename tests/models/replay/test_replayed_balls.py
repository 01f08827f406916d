"""Replay: the ball flies where it truly flew, and predictors see what had been measured by then."""

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from rallygap.models.policy.incoming_balls import (
    CONTROL_STEP,
    FIRST_WINDOW,
    PATH_TIMES,
    control_times,
    fly_incoming,
)
from rallygap.models.policy.launches import WORKSPACE
from rallygap.models.predictors.physics import PhysicsPredictor
from rallygap.models.predictors.protocol import FUTURE, HISTORY_TIMES, Forecast
from rallygap.models.predictors.windows import MIN_OBSERVED, observed_at
from rallygap.models.replay.replayed_balls import (
    anchored,
    every_step,
    fly_on,
    measured_in_time,
    measurement_histories,
    perturbed,
    predict_all,
    reachable,
    with_label_error,
)
from tests.models.policy.incoming_balls import HORIZONS, VACUUM, parabola
from tests.models.policy.replayed_shots import SERVE, STROKE, sampled, shot
from tests.models.predictors.balls import TRUTH
from tests.models.predictors.episodes import degraded

STEPS = control_times(FIRST_WINDOW)


class Numbers:
    """A predictor that numbers its histories by a thousand, and the states within."""

    def predict(self, history):
        first = 1000.0 * np.arange(len(history))
        states = first[:, None, None] + np.arange(1.0, FUTURE + 1)[:, None] + np.zeros(9)
        return Forecast(states, np.zeros(len(history), dtype=bool))


@pytest.mark.parametrize("known", [1, 500, len(PATH_TIMES)])
def test_a_ball_flies_on_from_where_it_is_known_last_and_can_be_played_after_its_bounce(known):
    shots = [shot(known=known), shot(first=SERVE, known=known)]
    path, playable = fly_on(TRUTH, shots)
    flown, expected = fly_incoming(TRUTH, np.array([STROKE, SERVE]))
    np.testing.assert_allclose(path, flown, atol=2e-5)
    for row, one in zip(path, shots, strict=True):
        np.testing.assert_array_equal(row[:known], one.known)
    served = TRUTH.fly(SERVE, PATH_TIMES).contacts
    np.testing.assert_allclose(playable[0], expected[0], atol=1e-6)
    assert served.before[0, 0, 1] > 0 > served.before[0, 1, 1]
    assert playable[1, 0] == pytest.approx(served.time[0, 1])
    assert playable[1, 1] > playable[1, 0]


def test_balls_are_within_reach_where_the_racket_strikes_while_they_can_be_played():
    middle = np.zeros((3, len(PATH_TIMES), 9))
    middle[:, 300:310, :3] = WORKSPACE.mean(axis=1)
    middle[1, :, 0] = WORKSPACE[0, 1] + 0.01
    playable = np.array([[0.2, 0.6], [0.2, 0.6], [0.32, 0.6]])
    assert reachable(middle, playable).tolist() == [True, False, False]


@pytest.mark.parametrize("rate", [143.0, 179.0, 200.0])
def test_histories_end_with_the_latest_sample_of_each_tick(rate):
    measured = degraded(sampled(rate=rate, noise=0.003), seed=1)
    found = measurement_histories([shot(), shot(measured)])
    for k, step in enumerate(STEPS):
        end = measured.times[measured.times <= step + 1e-9][-1]
        states, mask = observed_at(measured, end + HISTORY_TIMES, until=end)
        row = found.latest[1, k]
        if mask[:, :3].all(axis=1).sum() >= MIN_OBSERVED:
            np.testing.assert_array_equal(found.history.states[row], states)
            np.testing.assert_array_equal(found.history.mask[row], mask)
            assert found.age[1, k] == pytest.approx(step - end)
        else:
            assert found.age[1, k] > step - end


@settings(max_examples=15)
@given(k=st.integers(0, 16), seed=st.integers(0, 99), rate=st.sampled_from([143.0, 200.0]))
def test_nothing_that_was_measured_after_a_tick_reaches_the_predictor(k, seed, rate):
    measured = degraded(sampled(rate=rate), seed)
    later = measured.times > STEPS[k] + 1e-9
    other = replace(
        measured,
        positions=np.where(later[:, None], 9.0, measured.positions),
        spins=np.where(later[:, None], np.nan, measured.spins),
        outlier=measured.outlier ^ later,
        arc=measured.arc + later,
    )
    shorter = replace(
        measured,
        **{name: getattr(measured, name)[~later] for name in vars(measured) if name != "bounces"},
    )
    for one in (other, shorter):
        np.testing.assert_equal(inputs_until(shot(one), k), inputs_until(shot(measured), k))


def inputs_until(one, k):
    """The inputs of a predictor up to control step k."""
    found = measurement_histories([one])
    rows = found.latest[0, : k + 1]
    return found.history.states[rows], found.history.mask[rows], found.age[0, : k + 1]


def test_a_ball_that_is_lost_is_forecast_further_ahead_until_the_forecast_ends():
    found = measurement_histories([shot(sampled(until=0.098))])
    forecasts = every_step(predict_all(Numbers(), found.history), found, HORIZONS)[0, :, 0, 0]
    # The samples of 55 ms and of 95 ms; from there on the ball grows older by 8 states a tick.
    expected = [23.0, 1023.0, 1031.0, 1039.0, 1047.0, 1055.0, 1060.0, 1060.0]
    np.testing.assert_allclose(forecasts[:8], expected)


@pytest.mark.parametrize("rate", [143.0, 179.0, 200.0])
def test_a_measured_parabola_is_forecast_at_its_ticks_and_horizons(rate):
    times = np.arange(int(rate)) / rate
    states = parabola(times)
    thrown = replace(sampled(), times=times, positions=states[:, :3], spins=states[:, 6:])
    found = measurement_histories([shot(thrown)])
    expected = parabola(STEPS[:20, None] + np.array(HORIZONS) / 1000)
    every = every_step(predict_all(PhysicsPredictor(VACUUM), found.history), found, HORIZONS)
    np.testing.assert_allclose(every[0, :20], expected, atol=1e-3)
    for steps in (1, 4, None):
        states = anchored(PhysicsPredictor(VACUUM), found, HORIZONS, steps)
        np.testing.assert_allclose(states[0, :20], expected, atol=1e-3)


def test_between_forecasts_a_ball_is_forecast_from_the_last_one():
    found = measurement_histories([shot(), shot(first=SERVE)])
    predictor = PhysicsPredictor(TRUTH)
    states = anchored(predictor, found, HORIZONS, every=2)
    alone = anchored(predictor, found, HORIZONS, every=1)
    np.testing.assert_allclose(states[:, ::2], alone[:, ::2], atol=1e-9)
    flown = TRUTH.fly(alone[:, 2, 0], [CONTROL_STEP]).states[:, 0]
    np.testing.assert_allclose(states[:, 3, 0], flown, atol=1e-5)


def test_errors_of_labels_are_as_large_as_asked_and_the_same_in_all_labels_of_a_ball():
    unlabelled = replace(sampled(), spins=np.full((len(sampled().times), 3), np.nan))
    found = measurement_histories([shot()] * 200 + [shot(unlabelled)])
    wrong = with_label_error(found, 0.2, np.random.default_rng(0))
    error = wrong.history.states - found.history.states
    assert not error[..., :3].any()
    for first, last in zip(found.first[:3], found.first[1:4], strict=True):
        labelled = error[first:last, :, 3:][found.history.mask[first:last, :, 3]]
        np.testing.assert_allclose(labelled, labelled[:1].repeat(len(labelled), axis=0))
    spins = found.history.states[: found.first[1], :, 3:]
    size = 0.2 * np.linalg.norm(spins, axis=2).mean()
    assert error[found.first[:-1], -1, 3:].std() == pytest.approx(size, rel=0.1)
    assert not error[found.first[-1] :].any()


@pytest.mark.parametrize(("until", "enough"), [(0.3, True), (0.025, True), (0.02, False)])
def test_a_ball_must_have_been_seen_at_the_first_tick(until, enough):
    assert measured_in_time(sampled(until=until)) == enough


FORECASTS = np.random.default_rng(0).normal(size=(400, 20, 3, 9))


def wrong_by(error, size=0.05):
    return perturbed(FORECASTS, error, size, np.random.default_rng(1)) - FORECASTS


def test_a_bias_is_the_same_at_all_ticks_and_noise_is_drawn_at_every_tick():
    off = wrong_by("bias")[..., :3]
    np.testing.assert_allclose(np.linalg.norm(off, axis=-1), 0.05)
    np.testing.assert_allclose(off, np.broadcast_to(off[:, :1, :1], off.shape), atol=1e-12)
    assert np.abs(off[:, 0, 0].mean(axis=0)).max() < 0.006
    off = wrong_by("noise")[..., :3]
    assert np.sqrt((off**2).sum(axis=-1).mean()) == pytest.approx(0.05, rel=0.02)
    np.testing.assert_allclose(off, np.broadcast_to(off[:, :, :1], off.shape), atol=1e-12)
    assert abs(np.corrcoef(off[:, :-1, 0].ravel(), off[:, 1:, 0].ravel())[0, 1]) < 0.02


def test_errors_of_all_sizes_have_the_same_directions_and_are_of_positions_or_of_spins_alone():
    for error in ("bias", "noise"):
        assert not wrong_by(error)[..., 3:].any()
        np.testing.assert_allclose(wrong_by(error, 0.1), 2 * wrong_by(error, 0.05), atol=1e-12)
    off = wrong_by("no_spin")
    np.testing.assert_array_equal(off[..., 6:], -FORECASTS[..., 6:])
    assert not off[..., :6].any()
