"""Bullet worlds with the table and the arm, and many arms in one world."""

import tempfile
from pathlib import Path

import numpy as np
from numpy.typing import ArrayLike

from rallygap.models.ball.state import TABLE_HALF_LENGTH, TABLE_HALF_WIDTH
from rallygap.models.ball.types import Bools, Floats
from rallygap.models.robot.bullet import pybullet
from rallygap.models.robot.constants import (
    BASE,
    BULLET_STEP,
    FORCE,
    JOINTS,
    NEUTRAL,
    SPEED,
    TABLE_DEPTH,
)
from rallygap.models.robot.kinematics import rows_of_joints
from rallygap.models.robot.urdf import urdf

GRAVITY = 9.81  # m/s^2
# Groups of Bullet's collision filter: arms collide with the table, not with arms or themselves.
_TABLE, _ARM = 1, 2

_LINKS = list(range(len(JOINTS)))
_FORCES = FORCE.tolist()
_SPACING = 4.0  # m between two arms in the world, more than carriage and arm span


def open_world() -> int:
    """Return the id of a new world, in this process and without graphics."""
    client: int = pybullet.connect(pybullet.DIRECT)
    pybullet.setGravity(0, 0, -GRAVITY, physicsClientId=client)
    pybullet.setPhysicsEngineParameter(
        fixedTimeStep=BULLET_STEP,
        deterministicOverlappingPairs=1,
        # Or arms would be solved in one island and influence one another's results.
        minimumSolverIslandSize=1,
        physicsClientId=client,
    )
    return client


def add_table(client: int, aside: float = 0.0) -> int:
    """Put a table's slab into a world, moved by ``aside`` m along x; return its body."""
    half = [TABLE_HALF_WIDTH, TABLE_HALF_LENGTH, TABLE_DEPTH / 2]
    world = {"physicsClientId": client}
    shape = pybullet.createCollisionShape(pybullet.GEOM_BOX, halfExtents=half, **world)
    body: int = pybullet.createMultiBody(0, shape, basePosition=[aside, 0, -half[2]], **world)
    pybullet.setCollisionFilterGroupMask(body, -1, _TABLE, _ARM, **world)
    return body


def add_arm(client: int, aside: float = 0.0) -> int:
    """Put an arm into a world, moved by ``aside`` m along x; return its body."""
    world = {"physicsClientId": client}
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "arm.urdf"
        path.write_text(urdf())
        body: int = pybullet.loadURDF(
            str(path),
            [BASE[0] + aside, BASE[1], BASE[2]],
            useFixedBase=True,
            flags=pybullet.URDF_USE_INERTIA_FROM_FILE,
            **world,
        )
    pybullet.setCollisionFilterGroupMask(body, -1, 0, 0, **world)
    for link in range(len(JOINTS)):
        pybullet.setCollisionFilterGroupMask(body, link, _ARM, _TABLE, **world)
        pybullet.changeDynamics(
            body,
            link,
            linearDamping=0,
            angularDamping=0,
            maxJointVelocity=float(SPEED.max()),  # one for all joints of a body
            **world,
        )
    return body


class Arms:
    """B arms, each at a table of its own.

    In Bullet they stand far apart, so that it does not check pairs of arms for contact; joints are
    independent of the arm's place.
    """

    joints: Floats  # (B, 6) m, rad; a new array after every step and reset
    joint_speeds: Floats  # (B, 6) m/s, rad/s; likewise

    def __init__(self, count: int) -> None:
        client = open_world()
        self._world = {"physicsClientId": client}
        tables = [add_table(client, _SPACING * row) for row in range(count)]
        self._bodies = [add_arm(client, _SPACING * row) for row in range(count)]
        self._row = {
            body: row for bodies in (tables, self._bodies) for row, body in enumerate(bodies)
        }
        self.joints = self.joint_speeds = np.zeros((count, len(JOINTS)))
        self._touching = np.zeros(count, dtype=np.bool_)
        self.reset(np.ones(count, dtype=np.bool_))

    def reset(self, which: Bools) -> None:
        """Put the arms of ``which`` (B,) into neutral, at rest, and hold them there."""
        for row in np.flatnonzero(which).tolist():
            for link, value in enumerate(NEUTRAL.tolist()):
                pybullet.resetJointState(self._bodies[row], link, value, 0.0, **self._world)
            self._drive(row, [0.0] * len(JOINTS))
        self.joints = np.where(which[:, None], NEUTRAL, self.joints)
        self.joint_speeds = np.where(which[:, None], 0.0, self.joint_speeds)
        self._touching[which] = False

    def command(self, speeds: ArrayLike) -> None:
        """Set the drives' target joint speeds (B, 6), clipped to their limits."""
        for row, targets in enumerate(np.clip(rows_of_joints(speeds), -SPEED, SPEED).tolist()):
            self._drive(row, targets)

    def _drive(self, row: int, targets: list[float]) -> None:
        pybullet.setJointMotorControlArray(
            self._bodies[row],
            _LINKS,
            pybullet.VELOCITY_CONTROL,
            targetVelocities=targets,
            forces=_FORCES,
            **self._world,
        )

    def step(self) -> None:
        """Simulate ``BULLET_STEP``."""
        pybullet.stepSimulation(**self._world)
        states = [pybullet.getJointStates(body, _LINKS, **self._world) for body in self._bodies]
        self.joints = np.array([[joint[0] for joint in arm] for arm in states])
        self.joint_speeds = np.array([[joint[1] for joint in arm] for arm in states])
        self._touching[:] = False
        for contact in pybullet.getContactPoints(**self._world):
            body, force = contact[1], contact[9]
            self._touching[self._row[body]] |= force > 0.0

    def touching_table(self) -> Bools:
        """Return (B,) whether an arm, other than its base, pressed on the table in this step."""
        return self._touching.copy()

    def close(self) -> None:
        """Release the Bullet world."""
        pybullet.disconnect(**self._world)
