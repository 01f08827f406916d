"""Many robot arms in one Bullet world."""

from types import TracebackType

import numpy as np
import pybullet
from numpy.typing import ArrayLike

from rallygap.models.ball.types import Bools, Floats
from rallygap.models.robot.bullet import add_arm, add_table, open_world
from rallygap.models.robot.constants import FORCE, JOINTS, NEUTRAL, SPEED
from rallygap.models.robot.kinematics import rows_of_joints

_LINKS = list(range(len(JOINTS)))
_FORCES = FORCE.tolist()
_SPACING = 4.0  # m between two arms in the world, more than carriage and arm span


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

    def __enter__(self) -> "Arms":
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        traceback: TracebackType | None,
    ) -> None:
        self.close()
