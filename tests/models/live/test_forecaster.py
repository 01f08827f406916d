"""Live forecasts survive what cameras do: lost, late and wrong measurements, and other balls."""

import numpy as np
import pytest

from rallygap.models.ball.simulators import shipped
from rallygap.models.live.forecaster import NEW_BALL, Forecaster, NoBallError
from rallygap.models.live.track import KEPT
from rallygap.models.predictors.physics import PhysicsPredictor

TRUTH = shipped("literature")
FIRST = np.array([0.1, 1.2, 0.35, 0.3, -6.0, 1.0, -150.0, 20.0, 30.0])
ELSEWHERE = np.array([0.4, -1.0, 0.3, 0.0, 2.0, 1.0, 0.0, 0.0, 0.0])
TIMES = 0.005 * np.arange(40)
AHEAD = np.array([0.1, 0.2, 0.3])


def measured(first=FIRST, noise=0.002, times=TIMES, seed=0):
    places = TRUTH.fly(first, times).states[0, :, :3]
    return places + noise * np.random.default_rng(seed).normal(size=places.shape)


def watched(times, places, simulator=TRUTH):
    forecaster = Forecaster(simulator)
    seen = [forecaster.observe(t, place) for t, place in zip(times, places, strict=False)]
    return forecaster, seen


def miss(forecaster, first=FIRST, start=0.0):
    """Distances in m of the forecast from the true path, 100 to 300 ms after the measurements."""
    at = forecaster.last + AHEAD
    states, _ = forecaster.predict(at)
    true = TRUTH.fly(first, at - start).states[0]
    return np.linalg.norm(states[:, :3] - true[:, :3], axis=1)


def test_a_ball_is_forecast_better_the_longer_it_is_seen():
    misses = []
    for seed in range(15):
        places = measured(seed=seed)
        misses.append([miss(watched(TIMES[:n], places[:n])[0])[-1] for n in (6, 12, 36)])
    assert np.median(misses, axis=0) == pytest.approx([0.1, 0.04, 0.015], rel=0.7)
    assert (np.diff(np.median(misses, axis=0)) < 0).all()


def test_without_three_measurements_there_is_no_forecast():
    forecaster, _ = watched(TIMES[:2], measured()[:2])
    assert not forecaster.ready
    with pytest.raises(NoBallError, match="three times"):
        forecaster.predict([0.1])


def test_covariances_are_as_large_as_the_errors():
    distances = []
    for seed in range(40):
        forecaster, _ = watched(TIMES[:20], measured(noise=0.004, seed=seed))
        at = forecaster.last + AHEAD
        states, covariances = forecaster.predict(at)
        away = (states - TRUTH.fly(FIRST, at).states[0])[:, :3]
        solved = np.linalg.solve(covariances[:, :3, :3], away[..., None])[..., 0]
        distances.append((away * solved).sum(axis=1))
    # Three degrees of freedom; process noise for errors of simulators makes it less.
    assert (np.mean(distances, axis=0) < 4.0).all()
    assert (np.mean(distances, axis=0) > 0.5).all()


def test_late_measurements_count_as_if_they_had_come_in_time():
    places, order = measured(), np.arange(30)
    order[[9, 10, 11, 20, 21]] = [11, 10, 9, 21, 20]
    late, seen = watched(TIMES[order], places[order])
    expected, _ = watched(TIMES[:30], places[:30])
    assert set(seen) == {"used"}
    np.testing.assert_allclose(late.predict([0.3])[0], expected.predict([0.3])[0], rtol=1e-9)


def test_a_measurement_is_used_once_and_not_if_it_is_older_than_all_that_are_kept():
    times = 0.005 * np.arange(KEPT + 10)
    forecaster, _ = watched(times, measured(times=times))
    before = forecaster.predict([0.5])[0]
    assert forecaster.observe(times[20], measured(times=times)[20]) == "unused"
    assert forecaster.observe(times[0] + 0.001, measured(times=times)[0]) == "unused"
    assert (forecaster.predict([0.5])[0] == before).all()


def test_lost_frames_are_bridged_and_outliers_not_used():
    kept = np.r_[0:10, 22:36]
    forecaster, seen = watched(TIMES[kept], measured()[kept])
    assert set(seen) == {"used"}
    assert (miss(forecaster) < 0.05).all()
    for first in (0, 1, 2, 10, 29):
        places = measured()
        places[first] += np.array([0.3, -0.4, 0.5])
        forecaster, seen = watched(TIMES[:30], places[:30])
        assert (seen.count("used") >= 29 - NEW_BALL) and (miss(forecaster) < 0.05).all()


def test_a_second_ball_is_ignored_as_long_as_the_first_is_seen():
    other = measured(FIRST + ELSEWHERE, seed=1)
    forecaster = Forecaster(TRUTH)
    for t, place, elsewhere in zip(TIMES, measured(), other, strict=True):
        assert forecaster.observe(t, place) == "used"
        assert forecaster.observe(t, elsewhere) == "unused"
    assert (miss(forecaster) < 0.05).all()


def test_a_struck_ball_is_the_present_one_after_four_measurements():
    back = TRUTH.fly(FIRST, TIMES[20]).states[0, 0] * [1, 1, 1, -1, -1, 1, 1, 1, 1]
    times = np.r_[TIMES[:20], TIMES[20] + TIMES[:20]]
    forecaster, seen = watched(times, np.r_[measured()[:20], measured(back, seed=1)[:20]])
    assert "new ball" in seen[20 : 20 + NEW_BALL + 2]
    assert seen[-10:] == ["used"] * 10
    assert (miss(forecaster, back, TIMES[20]) < 0.1).all()
    for restart in (-1000.0, 500.0):  # the clock starts again
        times = np.r_[TIMES[:20], TIMES[:20] + restart]
        forecaster, seen = watched(times, np.r_[measured()[:20], measured(seed=1)[:20]])
        assert "new ball" in seen[20 : 20 + NEW_BALL + 1]
        assert (miss(forecaster, start=restart) < 0.08).all()


@pytest.mark.parametrize("position", [[0.0, np.nan, 0.0], [0.0, 1.0]])
def test_a_measurement_that_is_none_is_refused(position):
    with pytest.raises(ValueError, match="give 3 numbers"):
        Forecaster(TRUTH).observe(0.0, position)


def test_spins_make_the_forecast_of_spin_sure():
    without, _ = watched(TIMES[:12], measured()[:12])
    with_spin = Forecaster(TRUTH)
    for t, place in zip(TIMES[:12], measured(), strict=False):
        with_spin.observe(t, place, spin=FIRST[6:])
    ahead = with_spin.last + AHEAD
    assert with_spin.predict(ahead)[0][-1, 6:] == pytest.approx(FIRST[6:], abs=25.0)
    sizes = [np.sqrt(one.predict(ahead)[1][-1, 6, 6]) for one in (with_spin, without)]
    assert sizes[0] < 0.3 * sizes[1]


class Counting(PhysicsPredictor):
    """Counts how often it forecasts."""

    calls = 0

    def predict_with_covariances(self, history):
        self.calls += 1
        return super().predict_with_covariances(history)


def test_any_predictor_can_forecast_once_a_measurement():
    predictor = Counting(TRUTH)
    by_windows, (by_all, _) = Forecaster(TRUTH, predictor), watched(TIMES[:12], measured()[:12])
    for t, place in zip(TIMES[:12], measured(), strict=False):
        by_windows.observe(t, place)
        if by_windows.ready:
            by_windows.predict([t + 0.1])
    ahead = by_all.last + np.array([0.1, 0.1525, 0.3])
    states, covariances = by_windows.predict(ahead)
    expected, sure = by_all.predict(ahead)
    assert states[:, :3] == pytest.approx(expected[:, :3], abs=0.02)
    sizes = [np.sqrt(np.trace(one[:, :3, :3], axis1=1, axis2=2)) for one in (covariances, sure)]
    assert sizes[0] == pytest.approx(sizes[1], rel=0.3)
    assert by_windows.apex().time == pytest.approx(by_all.apex().time, abs=0.02)
    last = by_windows.predict([by_windows.last])
    np.testing.assert_allclose(last[0][0], by_windows.ball.state)
    np.testing.assert_allclose(last[1][0, :3, :3], by_windows.ball.covariance[:3, :3])
    with pytest.raises(ValueError, match="0 to 300 ms"):
        by_windows.predict([by_windows.last + 0.5])
    assert predictor.calls == 10
