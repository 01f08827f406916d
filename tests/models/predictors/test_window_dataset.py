"""Tracks: the same windows as one at a time, from one indexing; no episode meets another."""

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.stats import chisquare

from rallygap.models.predictors.protocol import TICK
from rallygap.models.predictors.window_dataset import build_tracks
from rallygap.models.predictors.windows import cut_windows
from tests.models.predictors.balls import FIRST
from tests.models.predictors.episodes import GRID, degraded, flown


def assert_windows_are_those_of(track, *episodes):
    """Both ways of cutting give the same numbers, but for the last bits of float32."""
    cuts = [cut_windows(episode, every=TICK) for episode in episodes]
    assert np.diff(track.bounds).tolist() == [len(cut) for cut in cuts if len(cut)]
    history, seen, future, measured = map(np.asarray, track.windows(track.anchors))
    np.testing.assert_array_equal(seen, np.concatenate([cut.history.mask for cut in cuts]))
    np.testing.assert_array_equal(measured, np.concatenate([cut.measured for cut in cuts]))
    states = np.concatenate([cut.history.states for cut in cuts]).astype(np.float32)
    later = np.concatenate([cut.future for cut in cuts]).astype(np.float32)
    np.testing.assert_allclose(history, states, rtol=3e-7, atol=3e-8)
    np.testing.assert_allclose(future, later, rtol=3e-7, atol=3e-8)


@pytest.mark.parametrize(
    ("times", "lost"),
    [
        (GRID, 0.1),
        (1234.565 + GRID, 0.6),
        (3.0 + np.arange(0, 0.6, 1 / 143), 0.1),
        (3.0 + np.arange(0, 0.6, 0.0056), 0.1),
    ],
)
def test_windows_of_a_spoilt_episode_at_any_rate_are_those_cut_one_at_a_time(times, lost):
    episode = degraded(flown(FIRST[1], times, noise=0.003), lost=lost)
    assert len(episode.bounces) > 0 and episode.outlier.any()
    assert np.isnan(episode.spins).any() and len(episode.times) < len(times)
    assert_windows_are_those_of(build_tracks([episode]), episode)


def test_stamps_rounded_to_microseconds_are_on_the_grid():
    episode = degraded(flown(noise=0.003), lost=0.4)
    jitter = np.random.default_rng(0).uniform(-4e-7, 4e-7, len(episode.times))
    moved = replace(episode, times=episode.times + jitter)
    exact, rounded = build_tracks([episode]), build_tracks([moved])
    assert len(rounded.history) == len(exact.history)  # one track, not one a window
    pairs = zip(exact.windows(exact.anchors), rounded.windows(rounded.anchors), strict=True)
    assert all(one.equal(other) for one, other in pairs)


@settings(max_examples=10)
@given(st.lists(st.tuples(st.integers(1, 60), st.booleans()), min_size=1, max_size=5))
def test_no_window_reaches_into_another_episode(lengths):
    on_grid, off_grid = flown(), flown(times=GRID * 1.1)
    whole = [(off_grid if off else on_grid, length) for length, off in lengths]
    episodes = [first(length, episode) for episode, length in [*whole, (on_grid, 40)]]
    joined = build_tracks(episodes)
    assert_windows_are_those_of(joined, *episodes)
    assert joined.episodes == sum(len(cut_windows(episode, TICK)) > 0 for episode in episodes)


def first(samples, episode):
    rows = ("times", "positions", "velocities", "spins", "outlier", "arc")
    return replace(episode, **{name: getattr(episode, name)[:samples] for name in rows})


def test_every_anchor_of_an_episode_is_drawn_equally_often():
    track = build_tracks([first(60, flown()), first(45, flown()), first(90, flown())])
    for episode in range(3):
        own = track.anchors[slice(*track.bounds[episode : episode + 2])]
        drawn = track.draw_anchors(np.full(200 * len(own), episode), np.random.default_rng(episode))
        assert np.isin(drawn, own).all()
        counts = (drawn[:, None] == own).sum(axis=0)
        assert chisquare(counts).pvalue > 1e-3
