"""Contact: exact on straight motions, and no ball passes through a blade unseen."""

import numpy as np
import pytest
from hypothesis import assume, given, settings
from hypothesis import strategies as st
from scipy.spatial.transform import Rotation

from rallygap.models.ball.state import BALL_RADIUS
from rallygap.models.robot.constants import RACKET_RADIUS
from rallygap.models.robot.contact import first_contact
from rallygap.models.robot.kinematics import Racket

STEP = 0.001  # s
MARGIN = 0.0005  # m by which a turning blade's straight step may be off
STILL = np.zeros(3)


def blade(position=STILL, normal=(0.0, 1.0, 0.0)):
    return Racket(np.atleast_2d(position), np.atleast_2d(normal), STILL[None], STILL[None])


def straight(start, end, **motion):
    """The meeting of one ball with one racket that does not turn."""
    return first_contact([start], [end], blade(), blade(**motion))


def vectors(size):
    return st.tuples(*[st.floats(-size, size)] * 3).map(np.array)


directions = (
    vectors(1.0).filter(lambda v: np.linalg.norm(v) > 0.1).map(lambda v: v / np.linalg.norm(v))
)


def oracle(ball, velocity, centre, moving, normal, turning, grown, fine=2000):
    """Brute force: whether a ball over a blade that is so much larger touches it in a step."""
    t = np.linspace(0, STEP, fine)[:, None]
    normals = Rotation.from_rotvec(turning * t).apply(normal)
    offset = ball - centre + (velocity - moving) * t
    height = np.einsum("ti,ti->t", offset, normals)
    level = np.linalg.norm(offset - height[:, None] * normals, axis=1)
    nearer = np.diff(np.abs(height), append=np.inf) < 0
    over = (level <= RACKET_RADIUS + grown) & (np.abs(height) <= BALL_RADIUS + grown)
    return bool((over & nearer).any())


@given(vectors(0.11), vectors(40.0), vectors(3.0), vectors(4.0), directions, vectors(15.0))
@settings(max_examples=200)
def test_meetings_are_those_of_brute_force(ball, velocity, centre, moving, normal, turning):
    assume(abs((velocity - moving) @ normal) > 3.0 and abs(ball @ normal) > MARGIN)
    motion = (ball + centre, velocity, centre, moving, normal, turning)
    turned = Rotation.from_rotvec(turning * STEP).apply(normal)
    found = first_contact(
        [ball + centre],
        [ball + centre + velocity * STEP],
        blade(centre, normal),
        blade(centre + moving * STEP, turned),
    ).met[0]
    assert oracle(*motion, -MARGIN) <= found <= oracle(*motion, MARGIN)


@given(
    speed=st.floats(1.0, 40.0),
    slant=st.floats(0.0, 1.3),
    around=st.floats(0.0, 2 * np.pi),
    out=st.floats(0.0, 0.95),
    moving=vectors(3.0),
    turning=vectors(5.0),
    early=st.floats(0.0, STEP),
)
@settings(max_examples=300)
def test_no_ball_goes_through_a_blade_unseen(speed, slant, around, out, moving, turning, early):
    """At time zero it is in the moving, turning blade's plane; looked at every millisecond."""
    times = np.arange(-60, 2) * STEP + early
    rim = np.array([np.cos(around), 0.0, np.sin(around)])
    towards = np.array([np.sin(slant), -np.cos(slant), 0.0])
    normals = Rotation.from_rotvec(np.outer(times, turning)).apply([0.0, 1.0, 0.0])
    offsets = out * RACKET_RADIUS * rim + np.outer(times, speed * towards)
    assume((np.einsum("ti,ti->t", offsets, normals)[times < 0] > 0).all())
    rackets = [blade(*now) for now in zip(np.outer(times, moving), normals, strict=True)]
    balls = (offsets + np.outer(times, moving))[:, None]
    steps = zip(balls[:-1], balls[1:], rackets[:-1], rackets[1:], strict=True)
    assert (
        next(step.side[0] for step in (first_contact(*step) for step in steps) if step.met[0]) == 1
    )


@pytest.mark.parametrize("speed", [5.0, 20.0, 40.0, 400.0])
def test_the_moment_is_that_at_which_the_surface_touches(speed):
    gap = 0.3 * speed * STEP
    start = np.array([0.0, BALL_RADIUS + gap, 0.0])
    found = straight(start, start - [0.0, speed * STEP, 0.0])
    assert found.share[0] == pytest.approx(0.3)
    assert (found.met[0], found.side[0]) == (True, 1)


@pytest.mark.parametrize(
    ("start", "end", "why"),
    [
        ([0, 0.015, 0], [0, 0.05, 0], "already on its way out"),
        ([-0.3, 0.021, 0], [0.3, 0.021, 0], "passes above"),
        ([0.05, 0.01, 0], [0.05, 0.01, 0.001], "slides along"),
    ],
)
def test_a_ball_that_does_not_come_onto_the_blade_is_not_met(start, end, why):
    found = straight(start, end)
    assert (found.met[0], found.side[0], np.isnan(found.share[0])) == (False, 0, True), why


def test_a_ball_already_touching_and_coming_nearer_is_met_at_once():
    assert straight([0, 0.015, 0], [0, -0.05, 0]).share[0] == 0.0
