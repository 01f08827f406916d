"""A ball in a PyBullet world, as a function that rallygap audits and diagnoses.

    rallygap audit docs/examples/pybullet_ball.py:fly --out audit

PyBullet has no air: drag and lift are forces that are applied before every step. Its defaults damp
all motion and make the ball a solid sphere, so both are set here.
"""

import math

import numpy as np
import pybullet
from numpy.typing import NDArray

Floats = NDArray[np.float64]

STEP = 1 / 1000  # s
MASS, RADIUS = 0.0027, 0.02  # kg, m
DRAG, LIFT = 0.47, 0.12  # C_D and C_M
RESTITUTION, FRICTION = 0.92, 0.25  # of the pair: PyBullet multiplies those of ball and table
DAMPING = 0.0  # PyBullet's default is 0.04, of linear and of angular motion
MOST_SPIN = 1e4  # rad/s; PyBullet's default cuts spins at 100
INERTIA = 2 / 3  # over m r^2; PyBullet's default is that of a solid sphere, 2/5
AIR = 1.2  # kg/m^3


def fly(states: Floats, times: Floats) -> Floats:
    """Fly balls, each alone in the world.

    Args:
        states: (B, 9) position (m), velocity (m/s) and spin (rad/s) in the table frame.
        times: (T,) s, rising.

    Returns:
        (B, T, 9) states.
    """
    client = pybullet.connect(pybullet.DIRECT)
    try:
        ball, _ = world(client)
        return np.array([_flight(client, ball, state, times) for state in states])
    finally:
        pybullet.disconnect(client)


def world(client: int) -> tuple[int, int]:
    """Make a world with a table and a ball; return the bodies of ball and table."""
    pybullet.setGravity(0, 0, -9.81, physicsClientId=client)
    pybullet.setTimeStep(STEP, physicsClientId=client)
    box = pybullet.createCollisionShape(
        pybullet.GEOM_BOX, halfExtents=[0.7625, 1.37, 0.0125], physicsClientId=client
    )
    sphere = pybullet.createCollisionShape(
        pybullet.GEOM_SPHERE, radius=RADIUS, physicsClientId=client
    )
    table = pybullet.createMultiBody(0, box, basePosition=[0, 0, -0.0125], physicsClientId=client)
    ball = pybullet.createMultiBody(MASS, sphere, physicsClientId=client)
    pybullet.changeDynamics(table, -1, restitution=1.0, lateralFriction=1.0, physicsClientId=client)
    pybullet.changeDynamics(
        ball,
        -1,
        restitution=RESTITUTION,
        lateralFriction=FRICTION,
        linearDamping=DAMPING,
        maxJointVelocity=MOST_SPIN,
        angularDamping=DAMPING,
        localInertiaDiagonal=[INERTIA * MASS * RADIUS**2] * 3,
        physicsClientId=client,
    )
    return ball, table


def _flight(client: int, ball: int, state: Floats, times: Floats) -> list[list[float]]:
    pybullet.resetBasePositionAndOrientation(
        ball, state[:3].tolist(), [0, 0, 0, 1], physicsClientId=client
    )
    pybullet.resetBaseVelocity(
        ball, state[3:6].tolist(), state[6:].tolist(), physicsClientId=client
    )
    flown: list[list[float]] = []
    now = 0.0
    for time in times:
        while now < time - STEP / 2:
            _push(client, ball)
            pybullet.stepSimulation(physicsClientId=client)
            now += STEP
        flown.append(_state(client, ball))
    return flown


def _push(client: int, ball: int) -> None:
    place, _ = pybullet.getBasePositionAndOrientation(ball, physicsClientId=client)
    velocity, spin = (
        np.array(part) for part in pybullet.getBaseVelocity(ball, physicsClientId=client)
    )
    drag = -0.5 * AIR * DRAG * math.pi * RADIUS**2 * np.linalg.norm(velocity) * velocity
    lift = AIR * LIFT * 4 / 3 * math.pi * RADIUS**3 * np.cross(spin, velocity)
    pybullet.applyExternalForce(
        ball, -1, (drag + lift).tolist(), place, pybullet.WORLD_FRAME, physicsClientId=client
    )


def _state(client: int, ball: int) -> list[float]:
    place, _ = pybullet.getBasePositionAndOrientation(ball, physicsClientId=client)
    velocity, spin = pybullet.getBaseVelocity(ball, physicsClientId=client)
    return [*place, *velocity, *spin]
