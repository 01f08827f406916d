"""The arm in Bullet: where its racket is, and the limits, masses and inertias of its file."""

import numpy as np
import pybullet
import pytest

from rallygap.models.robot.arms import add_arm, open_world
from rallygap.models.robot.constants import BLADE, JOINTS, LOWER, SPEED, UPPER, Solid
from rallygap.models.robot.kinematics import racket
from rallygap.models.robot.urdf import inertia

RACKET_LINK = len(JOINTS) - 1
POSES = np.random.default_rng(3).uniform(LOWER, UPPER, (40, len(JOINTS)))
MOTIONS = np.random.default_rng(4).uniform(-SPEED, SPEED, POSES.shape)


@pytest.fixture(scope="module")
def arm():
    client = open_world()
    yield {"bodyUniqueId": add_arm(client), "physicsClientId": client}
    pybullet.disconnect(physicsClientId=client)


def bullet_racket(arm, joints, speeds):
    """Position, normal, velocity and turning of the racket according to Bullet."""
    for index, (value, speed) in enumerate(zip(joints, speeds, strict=True)):
        pybullet.resetJointState(jointIndex=index, targetValue=value, targetVelocity=speed, **arm)
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


def grid(solid, n=60):
    """Points that fill a solid evenly, in its link's frame."""
    extent = solid.size if solid.shape == "box" else (*(2 * solid.size[0],) * 2, solid.size[1])
    ticks = (np.arange(n) + 0.5) / n - 0.5
    points = np.stack(np.meshgrid(*(ticks * length for length in extent)), -1).reshape(-1, 3)
    if solid.shape == "cylinder":
        points = points[np.hypot(points[:, 0], points[:, 1]) <= solid.size[0]]
    c, s = np.cos(solid.pitch), np.sin(solid.pitch)
    return points @ np.array([[1, 0, 0], [0, c, s], [0, -s, c]]) + solid.position


LINKS = [pytest.param(joint.link, id=joint.name) for joint in JOINTS]
TURNED_BOX = (Solid("box", (0.1, 0.2, 0.3), 1.0, (0.1, -0.2, 0.3), 0.7), Solid("box", (1, 1, 1), 2))


@pytest.mark.parametrize("link", [*LINKS, pytest.param(TURNED_BOX, id="turned")])
def test_inertia_is_that_of_the_mass_spread_over_the_solids(link):
    points = [grid(solid) for solid in link]
    weights = np.concatenate(
        [np.full(len(p), solid.mass / len(p)) for p, solid in zip(points, link, strict=True)]
    )
    points = np.concatenate(points)
    mass, centre, tensor = inertia(link)
    assert mass == pytest.approx(weights.sum())
    np.testing.assert_allclose(centre, weights @ points / mass, atol=1e-12)
    arms = points - centre
    spread = np.einsum("n,ni,nj->ij", weights, arms, arms)
    expected = np.trace(spread) * np.eye(3) - spread
    np.testing.assert_allclose(tensor, expected, atol=2e-3 * np.trace(expected))


@pytest.mark.parametrize("index", range(len(JOINTS)))
def test_bullet_has_the_limits_masses_and_inertias_of_the_constants(arm, index):
    mass, _, principal, centre, *_ = pybullet.getDynamicsInfo(linkIndex=index, **arm)
    expected_mass, expected_centre, tensor = inertia(JOINTS[index].link)
    assert mass == pytest.approx(expected_mass)
    np.testing.assert_allclose(centre, expected_centre, atol=1e-12)
    np.testing.assert_allclose(np.sort(principal), np.linalg.eigvalsh(tensor), rtol=1e-6)
    joint, info = JOINTS[index], pybullet.getJointInfo(jointIndex=index, **arm)
    kinds = {"prismatic": pybullet.JOINT_PRISMATIC, "revolute": pybullet.JOINT_REVOLUTE}
    assert (info[1].decode(), info[2]) == (joint.name, kinds[joint.kind])
    assert info[8:12] == (joint.lower, joint.upper, joint.force, joint.speed)
