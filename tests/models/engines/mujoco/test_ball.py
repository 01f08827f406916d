"""Which body of a scene is the ball, and what is said where none is or several are."""

import re

import pytest

from rallygap.models.engines.engine import EngineError
from rallygap.models.engines.mujoco.ball import find_ball
from tests.models.engines.mujoco.scenes import BALL, TABLE, ball, compiled

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
