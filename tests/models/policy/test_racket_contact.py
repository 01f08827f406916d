"""RacketContacts of balls and rackets within a tick."""

import numpy as np
import pytest

from rallygap.models.ball.state import BALL_RADIUS
from rallygap.models.policy.racket_contact import distances, find_contacts, racket_path
from rallygap.models.robot.constants import NEUTRAL
from rallygap.models.robot.kinematics import racket

STEPS = 40


def still_rackets(count, velocity=(0.0, 0.0, 0.0), turning=(0.0, 0.0, 0.0)):
    """Return rackets at the origin that face +y and, for the test's sake, stay there."""
    pose = np.concatenate([[0, 0, 0], [0, 1, 0], velocity, turning])
    return np.tile(pose, (STEPS + 1, count, 1))


def balls_at(places, speed=-10.0):
    """Return balls that are at ``places`` in mid-tick and move along y, 1 ms a step."""
    times = 0.001 * (np.arange(STEPS + 1) - STEPS / 2)
    states = np.zeros((STEPS + 1, len(places), 9))
    states[..., :3] = np.array(places)
    states[..., 1] += speed * times[:, None]
    states[..., 4] = speed
    return states


def met(balls, rackets, live=None):
    live = np.ones((STEPS, balls.shape[1]), dtype=bool) if live is None else live
    return find_contacts(balls, rackets, distances(balls, rackets), live)


def test_a_ball_is_met_at_the_face_whose_rubber_moves_with_the_turning_of_the_blade():
    rackets = still_rackets(1, velocity=(0.0, 1.0, 0.0), turning=(8.0, 0.0, 2.0))
    found = met(balls_at([(0.03, 0.0, 0.05)]), rackets)
    assert found.moments[0] == pytest.approx(STEPS / 2 - 1000 * BALL_RADIUS / 10.0)
    assert found.states[0, 1] == pytest.approx(BALL_RADIUS)
    np.testing.assert_allclose(found.normals, [[0, 1, 0]])
    # (8, 0, 2) x (0.03, 0, 0.05) = (0, 2 * 0.03 - 8 * 0.05, 0)
    np.testing.assert_allclose(found.velocities, [[0.0, 1.0 + 0.06 - 0.40, 0.0]], atol=1e-12)


def test_balls_within_the_blade_are_met_once_and_only_in_live_steps():
    places = [(0.0, 0.0, 0.0), (0.09, 0.0, 0.0), (0.0, 0.0, -0.07), (0.0, 0.0, 0.0)]
    there_and_back = balls_at(places)
    there_and_back[STEPS // 2 :] = there_and_back[STEPS // 2 :: -1]
    live = np.ones((STEPS, 4), dtype=bool)
    live[:, 3] = False
    assert met(there_and_back, still_rackets(4), live).envs.tolist() == [0, 2]


def test_rackets_swing_through_the_poses_of_their_joints():
    random = np.random.default_rng(1)
    joints = NEUTRAL + 0.02 * np.arange(6)[:, None, None] * random.uniform(-1, 1, (2, 6))
    speeds = np.broadcast_to(np.diff(joints, axis=0)[:1] / 0.004, joints.shape)
    poses = racket_path(joints, speeds, substeps=4)
    assert poses.shape == (21, 2, 12)
    for k in range(6):
        np.testing.assert_allclose(poses[4 * k, :, :3], racket(joints[k], speeds[k]).position)
    between = racket((joints[1] + joints[2]) / 2, speeds[0])
    np.testing.assert_allclose(poses[6, :, :3], between.position, atol=2e-5)
    np.testing.assert_allclose(poses[6, :, 3:6], between.normal, atol=2e-4)
