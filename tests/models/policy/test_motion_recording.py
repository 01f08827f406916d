"""The film: what it shows is what was played."""

from dataclasses import replace

import numpy as np
import pytest

from models.ball.state import BALL_RADIUS
from models.policy.batch_simulation import ACTIONS
from models.policy.incoming_balls import FLOOR
from models.policy.motion_recording import AFTERWARDS, FRAME, film
from models.policy.observation import observation_size
from models.policy.policy import Policy
from models.policy.trial import play
from models.robot.arms import Arms
from models.robot.constants import BULLET_STEP, NEUTRAL
from models.robot.kinematics import racket
from tests.models.policy.courts import CENTRE, SIMULATOR, beside_centre, goals, passing

WEIGHTS = np.zeros((ACTIONS, observation_size(3, 2, "strict")), dtype=np.float32)
BEGINNER = Policy(((WEIGHTS, np.array([0.0, 0.9, 0.0, 0.0, 0.0], dtype=np.float32)),))
"""Moves the racket ahead, whatever comes."""
RETURNED, TOO_FAST = passing(CENTRE), passing(CENTRE, velocity=(0.0, -8.0, 0.0))
ASIDE = passing(beside_centre(across=0.3))


def filmed(incoming):
    return film(BEGINNER, SIMULATOR, incoming, goals(), "strict")


def rackets(joints):
    return racket(joints, np.zeros_like(joints)).position


@pytest.fixture(scope="module")
def shot():
    return filmed(RETURNED)


@pytest.fixture(scope="module")
def played():
    return play(BEGINNER, SIMULATOR, RETURNED, goals(), "strict").iloc[0]


def test_the_ball_comes_as_it_does_until_it_is_hit_and_not_after(shot, played):
    before = FRAME * np.arange(len(shot.ball)) < played["time"]
    path = RETURNED.path[0, : 20 * len(before) : 20, :3]

    np.testing.assert_array_equal(shot.ball[before], path[before])
    assert (np.abs(shot.ball - path)[~before].max(axis=1) > 0.01).all()


def test_the_ball_turns_where_the_racket_is(shot, played):
    frame = round(played["time"] / FRAME)
    apart = np.linalg.norm(shot.ball - rackets(shot.joints), axis=1)

    assert played["hit"]
    assert apart.argmin() == frame
    assert apart[frame] < BALL_RADIUS + FRAME * played["speed"]


def test_a_return_is_seen_to_land_where_it_does_and_to_bounce(shot, played):
    landing = shot.ball[:, 2].argmin()

    assert played["returned"] and shot.returned
    assert landing == len(shot.ball) - 1 - round(AFTERWARDS / FRAME)
    assert shot.ball[landing, 2] == pytest.approx(BALL_RADIUS, abs=0.05)
    assert shot.ball[landing, 1] == pytest.approx(played["landing_along"], abs=0.06)
    assert shot.ball[-1, 2] > shot.ball[landing, 2]


def test_a_ball_that_goes_out_is_followed_to_the_floor():
    shot = filmed(TOO_FAST)
    on_floor = len(shot.ball) - 1 - round(AFTERWARDS / FRAME)

    assert not shot.returned
    assert shot.ball[on_floor - 1, 2] > FLOOR > shot.ball[on_floor + 1, 2]


def test_a_ball_that_is_missed_goes_on_until_it_is_gone():
    shot = filmed(ASIDE)

    assert not shot.returned
    np.testing.assert_array_equal(shot.ball, ASIDE.path[0, :401:20, :3])
    assert len(shot.joints) == len(shot.ball)


def test_the_arm_is_where_bullet_had_it(monkeypatch):
    """Between two ticks the film does not look, and is still right to 4 mm."""
    moves = [NEUTRAL]
    step = Arms.step

    def recorded(arms):
        step(arms)
        moves.append(arms.joints[0])

    monkeypatch.setattr(Arms, "step", recorded)
    shot = filmed(RETURNED)
    true = np.array(moves)[:: round(FRAME / BULLET_STEP)][: len(shot.joints)]
    np.testing.assert_array_equal(shot.joints[::2], true[::2])
    assert np.linalg.norm(rackets(shot.joints) - rackets(true), axis=1).max() < 0.004


def test_the_arm_waits_until_the_predictor_has_seen_the_ball():
    late = filmed(replace(ASIDE, start=0.055))
    waiting = FRAME * np.arange(len(late.joints)) < 0.055

    np.testing.assert_array_equal(late.joints[waiting], np.tile(NEUTRAL, (3, 1)))
    assert (late.joints[~waiting] != NEUTRAL).any(axis=1).all()
    assert len(late.joints) == len(filmed(ASIDE).joints)
