"""The arm as Bullet reads it: the constants' limits, masses and inertias of solids."""

import numpy as np
import pybullet
import pytest

from rallygap.models.robot.arms import add_arm, open_world
from rallygap.models.robot.constants import JOINTS, Solid
from rallygap.models.robot.urdf import inertia


@pytest.fixture(scope="module")
def arm():
    client = open_world()
    yield {"bodyUniqueId": add_arm(client), "physicsClientId": client}
    pybullet.disconnect(physicsClientId=client)


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


@pytest.mark.parametrize("link", range(len(JOINTS)))
def test_bullet_takes_mass_and_inertia_from_the_file(arm, link):
    mass, _, principal, centre, *_ = pybullet.getDynamicsInfo(linkIndex=link, **arm)
    expected_mass, expected_centre, tensor = inertia(JOINTS[link].link)
    assert mass == pytest.approx(expected_mass)
    np.testing.assert_allclose(centre, expected_centre, atol=1e-12)
    np.testing.assert_allclose(np.sort(principal), np.linalg.eigvalsh(tensor), rtol=1e-6)


@pytest.mark.parametrize("index", range(len(JOINTS)))
def test_bullet_knows_the_joints_limits(arm, index):
    joint, info = JOINTS[index], pybullet.getJointInfo(jointIndex=index, **arm)
    kinds = {"prismatic": pybullet.JOINT_PRISMATIC, "revolute": pybullet.JOINT_REVOLUTE}
    assert (info[1].decode(), info[2]) == (joint.name, kinds[joint.kind])
    assert info[8:12] == (joint.lower, joint.upper, joint.force, joint.speed)
