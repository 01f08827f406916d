"""IncomingBalls balls: when they can be played."""

import numpy as np
import pytest

from rallygap.models.policy.incoming_balls import (
    CONTROL_STEP,
    FIRST_WINDOW,
    MAX_DURATION,
    PATH_TIMES,
    control_times,
    fly_incoming,
)
from tests.models.policy.incoming_balls import TRUTH


def test_a_ball_is_playable_from_its_bounce_to_its_second_bounce_or_the_floor():
    dropped = np.array([0.0, -1.0, 0.3, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0])
    rolled_off = np.array([0.0, -1.0, 0.1, 0.0, -2.0, 0.0, 0.0, 0.0, 0.0])
    launches = np.array([dropped, rolled_off])
    path, playable = fly_incoming(TRUTH, launches)
    contacts = TRUTH.fly(launches, PATH_TIMES).contacts
    np.testing.assert_allclose(playable[:, 0], contacts.time[:, 0])
    np.testing.assert_allclose(playable[0, 1], contacts.time[0, 1])
    on_floor = np.interp(playable[1, 1], PATH_TIMES, path[1, :, 2])
    assert -0.745 < on_floor <= -0.74


def test_a_ball_is_gone_behind_the_robots_reach_or_after_the_longest_time():
    past = [0.0, 1.5, 0.35, 0.0, -12.0, -0.3, 200.0, 0, 0]
    high = [0.0, -0.8, 0.3, 0.0, 0.0, 4.0, 0.0, 0.0, 0.0]
    path, playable = fly_incoming(TRUTH, np.array([past, high]))
    assert -2.42 < np.interp(playable[0, 1], PATH_TIMES, path[0, :, 1]) <= -2.40
    assert playable[1, 1] == MAX_DURATION


def test_a_ball_that_does_not_come_to_the_robots_half_cannot_be_played():
    on_far_half = [0.0, 1.2, 0.3, 0.0, -2.0, 0.0, 0.0, 0.0, 0.0]
    too_long = [0.0, 1.2, 0.3, 0.0, -12.0, 2.0, 0.0, 0.0, 0.0]
    assert np.isnan(fly_incoming(TRUTH, np.array([on_far_half, too_long]))[1]).all()


@pytest.mark.parametrize("start", [0.0, FIRST_WINDOW])
def test_there_is_a_tick_at_every_moment_before_the_longest_time(start):
    ticks = control_times(start)
    assert ticks[0] == start and np.allclose(np.diff(ticks), CONTROL_STEP)
    assert ticks[-1] < MAX_DURATION - 1e-6 <= ticks[-1] + CONTROL_STEP
