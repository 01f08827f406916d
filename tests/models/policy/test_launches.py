"""Launches: every one of them can be played, and they are as varied as documented."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.spatial import KDTree

from rallygap.models.ball.contact_laws import TABLE
from rallygap.models.ball.state import BALL_RADIUS, NET_HEIGHT
from rallygap.models.policy import launches as documented
from rallygap.models.policy.incoming_balls import PATH_TIMES
from rallygap.models.policy.launches import draw_launches, draw_strokes, is_playable
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


@settings(max_examples=10)
@given(seed=st.integers(0, 2**32 - 1), count=st.integers(0, 40))
def test_the_same_seed_draws_the_same_launches(seed, count):
    launches = drawn(count, seed=seed)
    assert launches.shape == (count, 9)
    np.testing.assert_array_equal(launches, drawn(count, seed=seed))
    assert is_playable(TRUTH, launches).all()


def test_topspin_turns_the_upper_side_of_the_ball_ahead():
    strokes = draw_strokes(500, np.random.default_rng(0))
    top = np.cross(strokes[:, 6:], [0.0, 0.0, 1.0])[:, :2]
    ahead = np.einsum("bi,bi->b", top, strokes[:, 3:5])
    share = (ahead > 0).mean()
    assert abs(share - 250 / 350) < 0.1


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
