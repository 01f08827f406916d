"""Which body of a scene is the ball, and where the playing surface lies."""

import re

import numpy as np
import pytest

from rallygap.models.engines.engine import EngineError
from rallygap.models.engines.mujoco.ball import find_ball
from rallygap.models.engines.mujoco.frame import find_frame
from tests.models.engines.mujoco.scenes import BALL, TABLE, ball, compiled

HALF = '<geom name="{}" type="box" size=".685 .7625 .01" pos="{} 0 .75"/>'
# By a millimetre.
HIGHER = '<geom type="box" size=".685 .7625 .75" pos=".685 0 .011"/>'
STATES = np.random.default_rng(0).normal(size=(2, 3, 9))


def frame_of(world, option="", rest="", keep=None):
    model = compiled(world + (keep or ball()), option, rest)
    return find_frame(model, find_ball(model))


AXES = [[1, 0, 0], [0, 1, 0], [0, 0, 1]]
ALONG_X = '<geom type="box" size="1.37 .7625 .01" {}/>'
ON_ITS_SIDE = '<geom type="box" size=".7625 .01 1.37" euler="90 0 0"/>'
UPRIGHT = '<geom type="box" size=".7625 .01 1.37"/>'
TWO = TABLE + '<geom type="box" size=".7625 1.37 .01" pos="0 0 .5"/>'


@pytest.mark.parametrize(
    ("world", "option", "origin", "axes"),
    [
        (TABLE, "", [0, 0, 0], AXES),
        (ALONG_X.format('pos="1 2 .75"'), "", [1, 2, 0.76], [[0, -1, 0], [1, 0, 0], [0, 0, 1]]),
        (ON_ITS_SIDE, "", [0, 0, 0.01], AXES),
        (UPRIGHT, 'gravity="0 -9.81 0"', [0, 0.01, 0], [[-1, 0, 0], [0, 0, 1], [0, 1, 0]]),
        (TWO, "", [0, 0, 0.51], AXES),
    ],
    ids=["level", "along x", "on its side", "up is against gravity", "the highest of two"],
)
def test_the_frame_lies_on_the_table_along_it_and_up(world, option, origin, axes):
    frame = frame_of(world, option)
    np.testing.assert_allclose(frame.origin, origin, atol=1e-12)
    np.testing.assert_allclose(frame.axes.T, axes, atol=1e-9)
    assert frame.found
    assert (frame.length, frame.width) == pytest.approx((2.74, 1.525))


@pytest.mark.parametrize(
    ("degrees", "y"),
    [(30, [0.866, 0.5]), (100, [-0.174, 0.985]), (135, [0.707, -0.707]), (170, [0.985, -0.174])],
)
def test_y_points_along_the_nearest_axis_of_the_world(degrees, y):
    frame = frame_of(ALONG_X.format(f'euler="0 0 {degrees}"'))
    np.testing.assert_allclose(frame.axes[:2, 1], y, atol=1e-3)
    assert np.linalg.det(frame.axes) == pytest.approx(1.0)


@pytest.mark.parametrize("other", [HALF.format("other", 0.685), HIGHER])
def test_two_halves_and_their_net_are_a_table(other):
    net = '<geom type="box" size=".01 .9 .07625" pos="0 0 .836"/>'
    frame = frame_of(HALF.format("own", -0.685) + other + net)
    np.testing.assert_allclose(frame.origin, [0.0, 0.0, 0.76], atol=1e-12)
    assert len(frame.geoms) == 2
    assert frame.length == pytest.approx(2.74)


EXCLUDED = '<contact><exclude body1="desk" body2="ball"/></contact>'


def test_a_table_that_is_not_level_keeps_its_normal():
    frame = frame_of('<geom type="box" size=".7625 1.37 .01" euler="2 0 0"/>')
    normal = [0.0, -np.sin(np.radians(2)), np.cos(np.radians(2))]
    np.testing.assert_allclose(frame.axes[:, 2], normal, atol=1e-12)


@pytest.mark.parametrize(
    ("world", "keep", "rest"),
    [
        ("", None, ""),
        ('<geom type="plane" size="2 2 .1"/>', None, ""),
        ('<geom type="box" size="1 1 .1"/>', None, ""),
        (HALF.format("own", -0.685), None, ""),
        (HALF.format("own", -0.9) + HALF.format("other", 0.9), None, ""),
        (TABLE.replace("/>", ' contype="0" conaffinity="0"/>'), None, ""),
        (TABLE, ball(f'{BALL} contype="2" conaffinity="2"'), ""),
        (f'<body name="desk">{TABLE}</body>', None, EXCLUDED),
        ('<geom type="box" size=".7625 1.37 .01" euler="40 0 0"/>', None, ""),
    ],
)
def test_without_a_table_the_world_is_the_frame(world, keep, rest):
    frame = frame_of(world, rest=rest, keep=keep)
    assert not frame.found
    np.testing.assert_array_equal(frame.to_world(STATES), STATES)


def test_a_pair_lets_a_ball_meet_a_table():
    keep = ball(f'{BALL} name="sphere" contype="0" conaffinity="0"')
    pair = '<contact><pair geom1="sphere" geom2="top"/></contact>'
    assert frame_of(TABLE, rest=pair, keep=keep).found


def test_the_table_is_where_the_scene_starts():
    world = f'<body mocap="true" name="desk">{TABLE}</body>'
    key = '<keyframe><key mpos="0 0 .76"/></keyframe>'
    assert frame_of(world, rest=key).origin[2] == pytest.approx(0.76)


def test_states_return_from_the_world():
    frame = frame_of(ALONG_X.format('pos="1 2 .75" euler="0 0 20"'))
    world = frame.to_world(STATES)
    assert np.abs(world - STATES).max() > 0.5
    np.testing.assert_allclose(frame.to_table(world), STATES, atol=1e-12)
    speeds = [np.linalg.norm(states[..., 3:6], axis=-1) for states in (world, STATES)]
    np.testing.assert_allclose(*speeds)


RACKET = '<body name="racket"><freejoint/><geom type="box" size=".08 .08 .01" pos="2 0 0"/></body>'
MESH = '<asset><mesh name="round" vertex="0 0 0 .02 0 0 0 .02 0 0 0 .02"/></asset>'


def found(world, name=None, rest=""):
    return find_ball(compiled(world, rest=rest), name)


def test_the_ball_is_the_free_body_that_is_one_small_sphere():
    one = found(TABLE + RACKET + ball())
    assert (one.name, one.radius) == ("ball", 0.02)
    assert one.mass == pytest.approx(0.0027)
    assert (one.position, one.velocity) == (7, 6)


LOOK = '<geom type="box" size=".01 .01 .01" contype="0" conaffinity="0" mass="0"'
OFF = f'{BALL} name="sphere" contype="0" conaffinity="0"'


@pytest.mark.parametrize(
    ("world", "rest", "name"),
    [
        (ball(f"{BALL}/>{LOOK}"), "", "ball"),  # what does not collide does not count
        (TABLE + ball(OFF), '<contact><pair geom1="top" geom2="sphere"/></contact>', "ball"),
        (ball(OFF), "", "ball"),  # it meets nothing and still flies
        (ball(name=""), "", "body 1"),
    ],
)
def test_what_collides_decides_and_a_body_without_a_name_has_a_number(world, rest, name):
    assert found(world, rest=rest).name == name


@pytest.mark.parametrize(
    ("world", "problem"),
    [
        (TABLE, "there is no ball, .* no body is free, and none is one sphere"),
        (TABLE + RACKET, "there is no ball, .* racket collides as box; let one sphere collide"),
        (ball(joint=""), "ball has no free joint; give it <freejoint/>"),
        (ball(joint='<joint type="hinge"/>'), "ball has no free joint"),
        (ball('type="sphere" size="2"'), "a radius of 2, so the scene is in centimetres"),
        (ball('type="sphere" size="20"'), "a radius of 20, so the scene is in millimetres"),
        (ball('type="sphere" size=".04"'), "a radius of 40 mm; a ball has 20 mm"),
        (ball(f'{BALL} pos="0 0 .01"'), "its sphere or its mass off its origin"),
        (ball(f'{BALL}/><geom {BALL} pos=".1 0 0"'), "collides as sphere and sphere"),
        (ball('type="ellipsoid" size=".02 .02 .02"'), "collides as ellipsoid"),
        (ball('type="mesh" mesh="round"'), "collides as mesh"),
    ],
)
def test_a_scene_without_a_ball_says_what_comes_near(world, problem):
    with pytest.raises(EngineError, match=problem):
        found(world, rest=MESH)


@pytest.mark.parametrize(
    ("name", "problem"),
    [
        (None, "2 bodies can be the ball: ball, spare; name one"),
        ("bal", "there is no body called 'bal'; did you mean ball?"),
        ("racket", "the body 'racket' cannot be the ball: it collides as box"),
    ],
)
def test_one_of_several_balls_is_named_and_must_be_a_ball(name, problem):
    world = ball() + ball(name="spare") + RACKET
    assert found(world, "spare").name == "spare"
    with pytest.raises(EngineError, match=f"^{re.escape(problem)}"):
        found(world, name)
