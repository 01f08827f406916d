"""Where the racket is and how it moves, compared with Bullet."""

import numpy as np
import pybullet
import pytest

from rallygap.models.robot.arms import add_arm, open_world
from rallygap.models.robot.constants import BLADE, JOINTS, LOWER, NEUTRAL, SPEED, UPPER
from rallygap.models.robot.kinematics import racket

RACKET_LINK = len(JOINTS) - 1
POSES = np.random.default_rng(3).uniform(LOWER, UPPER, (40, len(JOINTS)))
MOTIONS = np.random.default_rng(4).uniform(-SPEED, SPEED, POSES.shape)


@pytest.fixture(scope="module")
def arm():
    client = open_world()
    yield {"bodyUniqueId": add_arm(client), "physicsClientId": client}
    pybullet.disconnect(physicsClientId=client)


def pose(arm, joints, speeds):
    for index, (value, speed) in enumerate(zip(joints, speeds, strict=True)):
        pybullet.resetJointState(jointIndex=index, targetValue=value, targetVelocity=speed, **arm)


def bullet_racket(arm, joints, speeds):
    """Position, normal, velocity and turning of the racket according to Bullet."""
    pose(arm, joints, speeds)
    state = pybullet.getLinkState(
        linkIndex=RACKET_LINK, computeLinkVelocity=1, computeForwardKinematics=1, **arm
    )
    axes = np.reshape(pybullet.getMatrixFromQuaternion(state[5]), (3, 3))
    centre = np.add(state[4], axes @ BLADE)
    return centre, axes[:, 1], state[6] + np.cross(state[7], centre - state[0]), state[7]


def test_the_racket_is_where_bullet_has_it_and_moves_alike(arm):
    ours = racket(POSES, MOTIONS)
    for row, (joints, speeds) in enumerate(zip(POSES, MOTIONS, strict=True)):
        position, normal, velocity, turning = bullet_racket(arm, joints, speeds)
        np.testing.assert_allclose(ours.position[row], position, atol=1e-7)
        np.testing.assert_allclose(ours.normal[row], normal, atol=1e-6)
        np.testing.assert_allclose(ours.velocity[row], velocity, atol=1e-5)
        np.testing.assert_allclose(ours.turning[row], turning, atol=1e-5)


def test_in_neutral_the_racket_waits_behind_the_table_and_faces_it():
    ours = racket([NEUTRAL], [NEUTRAL])
    np.testing.assert_allclose(ours.position[0], [0.0, -1.64, 0.30], atol=5e-3)
    np.testing.assert_allclose(ours.normal[0], [0.0, np.cos(0.2), np.sin(0.2)], atol=1e-12)
