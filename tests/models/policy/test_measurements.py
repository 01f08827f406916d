"""Measurements: how noisy they are, and which of them a predictor gets at each tick."""

import numpy as np

from models.policy.incoming import FIRST_WINDOW, tick_times
from models.policy.measurements import Measurements, first_sight, measure, sightings
from models.policy.settings import SensorNoise
from tests.models.policy.incoming_balls import struck

CLEAN = SensorNoise(position=0.0, spin=0.0)


def numbered(measured):
    """Balls whose measurement k reads 1 + k, of which so many are measured."""
    states = np.arange(1.0, 282.0)[:, None] * np.ones((len(measured), 1, 6))
    mask = (np.arange(281) < np.array(measured)[:, None])[..., None] & np.ones(6, dtype=bool)
    return Measurements(np.where(mask, states, 0.0), mask)


def test_measurements_without_noise_are_the_path_every_five_milliseconds_until_it_is_lost():
    _, path, playable = struck()
    seen = measure(path, playable[:, 1], CLEAN, np.random.default_rng(0))
    counts = np.floor(playable[:, 1] / 0.005 + 1e-6) + 1
    np.testing.assert_array_equal(seen.mask.sum(axis=1), np.tile(counts[:, None], 6))
    true = np.concatenate([path[:, ::5, :3], path[:, ::5, 6:]], axis=2)
    np.testing.assert_array_equal(seen.states, np.where(seen.mask, true, 0.0))


def test_noise_has_the_deviations_that_were_asked_for():
    _, path, _ = struck()
    noise, generator = SensorNoise(position=0.003, spin=0.05), np.random.default_rng(0)
    seen = measure(path, np.full(len(path), np.inf), noise, generator).states
    true = path[:, ::5]
    assert abs((seen[..., :3] - true[..., :3]).std() / 0.003 - 1) < 0.03
    share = (seen[..., 3:] - true[..., 6:]) / np.linalg.norm(true[..., 6:], axis=2, keepdims=True)
    assert abs(share.std() / 0.05 - 1) < 0.03


def test_windows_end_at_their_ticks():
    seen = sightings(numbered([281]))
    last = seen.history.states[seen.latest[0], -1, 0]
    ticks = tick_times(FIRST_WINDOW)
    np.testing.assert_allclose(0.005 * (last - 1), ticks)
    np.testing.assert_array_equal(np.diff(seen.history.states[..., 0], axis=1), 1.0)
    assert not seen.age.any()


def test_a_lost_ball_keeps_its_last_complete_window():
    # Complete windows of 12 end at measurements 12, 20, 28 and so on.
    seen = sightings(numbered([27, 28]))
    last = seen.history.states[seen.latest, -1, 0]
    np.testing.assert_array_equal(last[:, :4], [[12, 20, 20, 20], [12, 20, 28, 28]])
    np.testing.assert_array_equal(seen.age[:, :4], [[0, 0, 8, 16], [0, 0, 0, 8]])
    assert len(seen.history) == 5 and seen.history.mask.all()


def test_a_ball_lost_at_once_has_one_window_with_what_was_seen():
    seen = sightings(numbered([3, 0]))
    assert len(seen.history) == 2
    np.testing.assert_array_equal(seen.history.mask[..., 0].sum(axis=1), [3, 0])
    np.testing.assert_array_equal(seen.age[:, 1], 8)


def test_histories_of_short_recordings_are_filled_with_nothing():
    whole = numbered([9])
    short = Measurements(whole.states[:, :9], whole.mask[:, :9])
    np.testing.assert_array_equal(first_sight(short).states, first_sight(whole).states)
    np.testing.assert_array_equal(sightings(short).history.mask, sightings(whole).history.mask)
