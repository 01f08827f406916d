"""Bullet worlds: time step, contact filters, the table and the arm."""

import tempfile
from pathlib import Path

import pybullet

from rallygap.models.ball.state import TABLE_HALF_LENGTH, TABLE_HALF_WIDTH
from rallygap.models.robot.constants import BASE, BULLET_STEP, JOINTS, SPEED, TABLE_DEPTH
from rallygap.models.robot.urdf import urdf

GRAVITY = 9.81  # m/s^2
# Groups of Bullet's collision filter: arms collide with the table, not with arms or themselves.
_TABLE, _ARM = 1, 2


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
