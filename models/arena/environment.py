"""The surroundings of the table: the floor, and the volume that the cameras see."""

import numpy as np
from numpy.typing import NDArray

from models.ball.contact_laws import ROLLING
from models.ball.state import BALL_RADIUS, POSITION, SPIN, VELOCITY

Floats = NDArray[np.float64]

FLOOR = -0.76  # m: a table is 76 cm high (ITTF Law 2.1.2)
FLOOR_RESTITUTION = 0.80  # assumption for a rubber sports floor
FLOOR_FRICTION = 0.40  # assumption

VIEW_HALF_WIDTH = 2.5  # m to each side of the table's middle
VIEW_HALF_LENGTH = 4.5  # m


def in_view(states: Floats) -> NDArray[np.bool_]:
    """Return for (..., 9) states whether the cameras see the ball."""
    x, y, z = np.moveaxis(states[..., POSITION], -1, 0)
    seen: NDArray[np.bool_] = (
        (np.abs(x) < VIEW_HALF_WIDTH) & (np.abs(y) < VIEW_HALF_LENGTH) & (z > FLOOR)
    )
    return seen


def bounce_off_floor(states: Floats) -> Floats:
    """Return (B, 9) states just after the floor, by the table's contact law (Nakashima 2010)."""
    after = states.copy()
    vx, vy, vz = states[:, VELOCITY].T
    wx, wy, _ = states[:, SPIN].T
    slip = np.stack([vx - BALL_RADIUS * wy, vy + BALL_RADIUS * wx], axis=1)
    grip = FLOOR_FRICTION * (1 + FLOOR_RESTITUTION) * np.abs(vz)
    speed = np.maximum(np.linalg.norm(slip, axis=1), 1e-12)
    alpha = np.minimum(grip / speed, ROLLING)[:, None]
    after[:, 3:5] -= alpha * slip
    after[:, 5] = FLOOR_RESTITUTION * np.abs(vz)
    after[:, 6:8] += 1.5 / BALL_RADIUS * alpha * slip[:, ::-1] * [-1, 1]
    return after
