"""The history of a track is what a predictor would have read from a recording."""

import numpy as np
import pytest

from rallygap.models.ball.simulators import shipped
from rallygap.models.live.track import Track, history_of

TRUTH = shipped("literature")
FIRST = np.array([0.1, 1.2, 0.35, 0.3, -6.0, 1.0, -150.0, 20.0, 30.0])
NOISE = 1e-6 * np.eye(3)
NONE = np.full(3, np.nan)


def tracked(times, labelled=()):
    track = Track(TRUTH)
    for k, (t, state) in enumerate(zip(times, TRUTH.fly(FIRST, times).states[0], strict=True)):
        assert track.add(t, state[:3], NOISE, FIRST[6:] if k in labelled else NONE)
    return track


def places(times):
    return TRUTH.fly(FIRST, np.maximum(times, 0.0)).states[0, :, :3]


def test_measurements_on_the_grid_are_the_history():
    times = 0.005 * np.arange(20)
    history = history_of(tracked(times, labelled=(10, 19)))
    assert history.mask[..., :3].all()
    assert history.states[0, :, :3] == pytest.approx(places(times[-12:]), abs=1e-9)
    assert np.flatnonzero(history.mask[0, :, 3]).tolist() == [2, 11]
    assert history.states[0, 2, 3:] == pytest.approx(FIRST[6:])


def test_other_times_are_interpolated():
    times = np.arange(0.0, 0.1, 0.0077)
    history = history_of(tracked(times))
    grid = times[-1] + 0.005 * np.arange(-11, 1)
    assert history.mask[..., :3].all()
    assert history.states[0, :, :3] == pytest.approx(places(grid), abs=1e-3)


def test_long_gaps_and_what_was_before_the_first_measurement_are_not_measured():
    times = 0.005 * np.r_[0:4, 8:11]
    history = history_of(tracked(times))
    assert np.flatnonzero(history.mask[0, :, 0]).tolist() == [1, 2, 3, 4, 9, 10, 11]
    assert np.flatnonzero(history_of(tracked(times[:1])).mask[0, :, 0]).tolist() == [11]
