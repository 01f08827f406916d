"""Launches are as varied as documented and can be played; balls, until they are gone."""

import numpy as np
import pytest
from scipy.spatial import KDTree

from rallygap.models.ball.contact_laws import TABLE
from rallygap.models.ball.state import BALL_RADIUS, NET_HEIGHT
from rallygap.models.policy import launches as documented
from rallygap.models.policy.incoming_balls import MAX_DURATION, PATH_TIMES, fly_incoming
from rallygap.models.policy.launches import draw_launches, is_playable
from rallygap.models.robot.constants import LOWER, NEUTRAL, UPPER
from rallygap.models.robot.kinematics import racket
from tests.models.policy.incoming_balls import TRUTH, VACUUM, WRONG


def drawn(count, simulator=TRUTH, seed=0):
    return draw_launches(simulator, count, np.random.default_rng(seed))


@pytest.mark.parametrize("simulator", [TRUTH, WRONG])
def test_launches_bounce_on_the_robots_half_and_come_to_the_racket_before_they_do_again(simulator):
    flight = simulator.fly(drawn(300, simulator), PATH_TIMES)
    contacts = flight.contacts
    behind = (flight.states[..., 1] < 0).argmax(axis=1)
    height = flight.states[np.arange(300), behind, 2]
    assert (height > NET_HEIGHT + BALL_RADIUS - 0.02).all()  # 1 ms further on
    assert (contacts.surface[:, 0] == TABLE).all() and (contacts.before[:, 0, 1] < 0).all()
    between = (contacts.time[:, :1] < PATH_TIMES) & ~(contacts.time[:, 1:2] <= PATH_TIMES)
    places, (lower, upper) = flight.states[..., :3], documented.WORKSPACE.T
    inside = ((lower <= places) & (places <= upper)).all(axis=2)
    assert (between & inside).any(axis=1).all()


def test_launches_are_of_all_speeds_and_spins():
    launches = drawn(1500)
    speed = np.linalg.norm(launches[:, 3:6], axis=1)
    assert speed.min() < 4.3 < 11.3 < speed.max() < 12.0 + 1e-9
    assert 5.5 < np.median(speed) < 8.0
    assert launches[:, 6].min() < -80 and launches[:, 6].max() > 230
    assert np.abs(launches[:, 8]).max() > 90
    assert np.linalg.norm(launches[:, 6:], axis=1).max() < 275


def test_a_ball_hit_to_where_the_racket_cannot_be_in_time_is_not_fair():
    fast = np.array([0.7, 1.6, 0.5, 0.0, -15.0, -1.2, 300.0, 0.0, 0.0])
    slow = np.array([0.0, 1.6, 0.3, 0.0, -5.0, 2.5, 0.0, 0.0, 0.0])
    middle = fast * [0, 1, 1, 1, 1, 1, 1, 1, 1]
    assert is_playable(TRUTH, np.array([fast, middle, slow])).tolist() == [False, True, True]


def test_an_environment_without_a_table_has_no_launches():
    with pytest.raises(ValueError, match="hardly any stroke"):
        drawn(10, VACUUM)


def test_the_workspace_is_where_the_arm_can_hold_its_racket_towards_the_table():
    home = racket([NEUTRAL], np.zeros((1, 6))).position
    np.testing.assert_allclose(home[0], documented.RACKET_HOME, atol=0.01)
    joints = np.random.default_rng(0).uniform(LOWER, UPPER, (50_000, 6))
    held = racket(joints, np.zeros_like(joints))
    places = held.position[held.normal[:, 1] > 0.7]
    corners = np.stack(np.meshgrid(*documented.WORKSPACE, indexing="ij"), axis=-1).reshape(-1, 3)
    assert KDTree(places).query(corners)[0].max() < 0.1


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
