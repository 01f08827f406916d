"""Recorded motions show what was played."""

from dataclasses import replace

import numpy as np
import pytest

from rallygap.models.ball.state import BALL_RADIUS
from rallygap.models.policy.incoming_balls import FLOOR
from rallygap.models.policy.motion_recording import AFTERWARDS, FRAME
from rallygap.models.policy.policy import Policy
from rallygap.models.policy.trial import play
from rallygap.models.robot.constants import NEUTRAL
from tests.models.policy.schooling import resting_policy
from tests.models.policy.simulations import CENTRE, SIMULATOR, beside_centre, goals, passing

((WEIGHTS, BIAS),) = resting_policy().layers
FORWARD = Policy(((WEIGHTS, BIAS + np.float32([0.0, 0.9, 0.0, 0.0, 0.0])),))  # whatever comes
RETURNED, TOO_FAST = passing(CENTRE), passing(CENTRE, velocity=(0.0, -8.0, 0.0))
ASIDE = passing(beside_centre(across=0.3))
SHORT = round(AFTERWARDS / FRAME)  # frames after the ball is down


def recorded(incoming, record=1):
    return play(FORWARD, SIMULATOR, incoming, goals(len(incoming)), "strict", record)


def test_a_return_bounces_where_it_lands():
    trial = recorded(RETURNED)
    (motion,), row = trial.motions, trial.table.iloc[0]
    landing = motion.ball[:, 2].argmin()
    assert row["returned"] and landing == len(motion.ball) - 1 - SHORT
    assert motion.ball[landing, 2] == pytest.approx(BALL_RADIUS, abs=0.05)
    assert motion.ball[landing, 1] == pytest.approx(row["landing_along"], abs=0.06)
    assert motion.ball[-1, 2] > motion.ball[landing, 2]


def test_a_ball_is_followed_to_the_floor_or_until_it_is_out_of_play_from_the_first_window():
    (out,), (missed,) = recorded(TOO_FAST).motions, recorded(replace(ASIDE, start=0.055)).motions
    on_floor = len(out.ball) - 1 - SHORT
    assert out.ball[on_floor - 1, 2] > FLOOR > out.ball[on_floor + 1, 2]
    np.testing.assert_array_equal(missed.ball, ASIDE.path[0, :401:20, :3])
    waiting = FRAME * np.arange(len(missed.ball)) < 0.055
    np.testing.assert_array_equal(missed.joints[waiting], np.tile(NEUTRAL, (3, 1)))
    assert (missed.joints[~waiting] != NEUTRAL).any(axis=1).all()


def test_recording_changes_nothing_and_motions_are_those_of_single_trials(monkeypatch):
    monkeypatch.setattr("rallygap.models.policy.trial.ENVIRONMENTS", 2)
    places = [CENTRE, beside_centre(across=0.3), beside_centre(across=0.03), CENTRE]
    balls = passing(*places)
    plain, several = recorded(balls, 0), recorded(balls, 3)
    assert plain.table.equals(several.table) and plain.motions == ()
    np.testing.assert_array_equal(plain.after_racket, several.after_racket)
    for motion, place in zip(several.motions, places[:3], strict=True):
        (single,) = recorded(passing(place)).motions
        np.testing.assert_array_equal(motion.joints, single.joints)
        np.testing.assert_array_equal(motion.ball, single.ball)
