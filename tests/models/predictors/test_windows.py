"""Windows: nothing from the future in the history, nothing unmeasured in the future."""

from dataclasses import replace

import numpy as np
import pytest

from rallygap.models.predictors.protocol import FUTURE_TIMES, HISTORY_TIMES
from rallygap.models.predictors.windows import Episode, cut_windows
from tests.models.predictors.episodes import GRID


def path(times):
    """A smooth path with exact velocities."""
    t = np.asarray(times)[:, None]
    return np.hstack([0.3 * t, 1.2 - 6 * t, 0.3 + t - 4.9 * t**2]), np.hstack(
        [0.3 + 0 * t, -6 + 0 * t, 1 - 9.8 * t]
    )


def episode(times, bounce=None, outlier=()):
    times = np.asarray(times, dtype=float)
    positions, velocities = path(times)
    spins = np.tile([10.0, -20.0, 30.0], (len(times), 1))
    arc = np.zeros(len(times), dtype=int) if bounce is None else (times > bounce).astype(int)
    marked = np.isin(np.arange(len(times)), outlier)
    bounces = np.array([] if bounce is None else [bounce])
    return Episode(times, positions, velocities, spins, marked, arc, bounces)


@pytest.mark.parametrize("times", [GRID, 7.0 + GRID, np.cumsum(np.full(90, 0.007))])
def test_the_first_window_ends_with_the_twelfth_tick_and_the_rest_follow(times):
    cut = cut_windows(episode(times), every=0.05)
    assert cut.anchors[0] - times[0] == pytest.approx(0.055, abs=0.0071)
    np.testing.assert_allclose(np.diff(cut.anchors), 0.05, atol=0.0071)
    assert cut.anchors[-1] <= times[-1] - 0.1
    assert np.isin(cut.anchors, times).all()


@pytest.mark.parametrize("interval", [0.005, 0.0056, 0.007])
def test_values_between_samples_are_interpolated(interval):
    times = np.arange(0, 0.6, interval)
    cut = cut_windows(episode(times), every=0.05)
    true, _ = path((cut.anchors[:, None] + HISTORY_TIMES).ravel())
    seen = cut.history.mask[..., :3].reshape(-1, 3)
    error = np.abs(cut.history.states[..., :3].reshape(-1, 3) - true)[seen]
    assert error.max() < 9.8 * interval**2 / 8 + 1e-12
    assert seen.mean() > 0.95


def test_the_history_knows_nothing_of_the_future():
    whole = episode(np.arange(0, 0.6, 0.007))
    cut = cut_windows(whole, every=0.05)
    for k, anchor in enumerate(cut.anchors):
        past = whole.times <= anchor
        later = replace(whole, positions=np.where(past[:, None], whole.positions, 99.0))
        states = cut_windows(later, every=0.05).history.states[k]
        np.testing.assert_array_equal(states, cut.history.states[k])


def test_the_future_is_not_interpolated_across_a_bounce():
    cut = cut_windows(episode(GRID, bounce=0.2025), every=0.05)
    ahead = cut.anchors[:, None] + FUTURE_TIMES
    straddling = np.abs(ahead - 0.2025) < 0.0024
    assert not cut.measured[straddling].any()
    assert (cut.bounced == ((ahead >= 0.2025) & (cut.anchors[:, None] < 0.2025))).all()


def test_outliers_are_no_measure_of_a_forecast_but_stay_in_the_history():
    clean, degraded = episode(GRID), episode(GRID, outlier=[20])
    degraded.positions[20] += 0.5
    cut = cut_windows(degraded, every=0.05)
    np.testing.assert_allclose(
        cut.future[0][cut.measured[0]],
        cut_windows(clean, 0.05).future[0][cut.measured[0]],
        atol=1e-3,
    )
    assert (np.abs(cut.history.states[..., 0]) > 0.5).any()


def test_a_long_gap_is_left_open():
    times = np.concatenate([GRID[:30], GRID[36:]])
    cut = cut_windows(episode(times), every=0.05)
    inside = (cut.anchors[0] + FUTURE_TIMES > 0.146) & (cut.anchors[0] + FUTURE_TIMES < 0.179)
    assert not cut.measured[0][inside].any()
    assert cut.measured[0][~inside].all()


def test_a_spin_is_kept_where_it_was_measured_and_masked_and_zero_elsewhere():
    sparse = episode(GRID)
    sparse.spins[1::2] = np.nan
    cut = cut_windows(sparse, every=0.05)
    ticks = np.round((cut.anchors[:, None] + HISTORY_TIMES) / 0.005).astype(int)
    even = ticks % 2 == 0
    np.testing.assert_array_equal(cut.history.mask[..., 3:].all(axis=2), even)
    np.testing.assert_array_equal(cut.history.states[..., 3], np.where(even, 10.0, 0.0))
    ahead = np.round((cut.anchors[:, None] + FUTURE_TIMES) / 0.005).astype(int)
    assert not cut.measured[ahead % 2 == 1][:, 6:].any()
    assert not cut.future[ahead % 2 == 1][:, 6:].any()


def test_six_ticks_of_twelve_are_enough_to_see():
    for before, enough in ((5, True), (4, False)):  # with the sample at the anchor, one more
        late = episode(np.concatenate([GRID[:before], GRID[11:]]))
        assert (cut_windows(late, every=0.05).anchors[0] == GRID[11]) == enough
