"""Shots: turned, begun at their launch, and measured on where the recording ends."""

from dataclasses import replace

import numpy as np
import pytest

from rallygap.models.policy.incoming_balls import PATH_TIMES
from rallygap.models.policy.settings import SensorNoise
from rallygap.models.replay.shots import (
    NO_MEASUREMENTS,
    Shot,
    extend_measurements,
    flies_away,
    from_launch,
    half_turn,
)
from tests.models.policy.replayed_shots import STROKE, sampled, shot
from tests.models.predictors.balls import TRUTH
from tests.models.predictors.episodes import flown

CLEAN = SensorNoise(position=0.0, spin=0.0)
PATH = TRUTH.fly(STROKE, PATH_TIMES).states


def measured_on(one, until=0.8, noise=CLEAN):
    random = np.random.default_rng(0)
    return extend_measurements([one], PATH, np.array([until]), noise, random)[0].measured


def test_an_episode_begins_at_its_first_sample():
    late = flown(STROKE, 3.05 + 0.005 * np.arange(101))
    begun, expected = from_launch(late), sampled(until=0.5)
    for name in ("times", "positions", "bounces"):
        np.testing.assert_allclose(getattr(begun, name), getattr(expected, name), atol=1e-9)


def test_half_a_turn_is_a_flight_of_the_same_physics_the_other_way():
    away = half_turn(sampled())
    assert flies_away(away) and not flies_away(sampled())
    turn = np.tile([-1.0, -1.0, 1.0], 3)
    flight = TRUTH.fly(STROKE * turn, away.times).states[0]
    np.testing.assert_allclose(away.positions, flight[:, :3], atol=1e-9)
    np.testing.assert_allclose(away.spins, flight[:, 6:], atol=1e-9)


@pytest.mark.parametrize("rate", [143.0, 200.0])
def test_a_ball_is_measured_on_after_its_last_sample(rate):
    own = sampled(until=0.3, rate=rate)
    seen = measured_on(shot(own, known=310))
    count = len(own.times)
    np.testing.assert_array_equal(seen.positions[:count], own.positions)
    gaps = np.diff(seen.times[count - 1 :])
    assert 0.0024 < gaps[0] < 0.0076 and np.allclose(gaps[1:], 0.005)
    assert seen.times[-1] == pytest.approx(0.8)
    path = PATH[0, np.rint(seen.times[count:] / 0.001).astype(int)]
    np.testing.assert_allclose(seen.positions[count:], path[:, :3], atol=1e-9)
    np.testing.assert_allclose(seen.spins[count:], path[:, 6:], atol=1e-9)
    hidden = replace(own, spins=np.full_like(own.spins, np.nan))
    assert np.isnan(measured_on(shot(hidden, known=310)).spins).all()


def test_samples_beyond_the_known_path_make_way_for_those_of_the_replayed_flight():
    other = sampled(until=0.5)
    moved = replace(other, positions=np.where(other.times[:, None] > 0.3, 9.0, other.positions))
    seen = measured_on(shot(moved, known=301))
    np.testing.assert_allclose(seen.positions, PATH[0, : 5 * len(seen.times) : 5, :3], atol=1e-9)


def test_a_ball_that_was_not_measured_is_measured_from_its_launch_on():
    seen = measured_on(Shot(NO_MEASUREMENTS, PATH[0], np.empty(0)))
    np.testing.assert_allclose(seen.times, 0.005 * np.arange(161))
    np.testing.assert_allclose(seen.positions, PATH[0, :801:5, :3])
