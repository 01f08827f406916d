"""Random deviations of table bounces from the contact law.

Each bounce follows the law of the simulator, with two random factors: one on the normal speed of
the rebound, one on the tangential impulse and the change of spin that belongs to it. The angular
momentum about the contact point is conserved, and the energy does not grow.
"""

from dataclasses import dataclass

import numpy as np

from rallygap.models.ball.contact_laws import ROLLING
from rallygap.models.ball.simulator import Simulator
from rallygap.models.ball.state import (
    BALL_RADIUS,
    POSITION,
    SPIN,
    TABLE_HALF_LENGTH,
    TABLE_HALF_WIDTH,
    VELOCITY,
)
from rallygap.models.ball.types import Floats


@dataclass(frozen=True)
class BounceScatter:
    """Standard deviations of the two factors."""

    restitution: float  # on the normal speed of the rebound
    friction: float  # on the tangential impulse

    def apply(
        self, simulator: Simulator, before: Floats, after: Floats, random: np.random.Generator
    ) -> Floats:
        """Return the (B, 9) states just after bounces, with random deviations; two draws per ball.

        Args:
            simulator: whose contact law the bounces follow.
            before: (B, 9) states just before.
            after: (B, 9) states just after, by the law.
            random: of the deviations.
        """
        normal = table_normals(simulator, before[:, POSITION])
        deviations = random.standard_normal((len(before), 2))
        bounce = 1 + self.restitution * deviations[:, 0]
        grip = np.maximum(1 + self.friction * deviations[:, 1], 0)
        into, out = -_dot(before[:, VELOCITY], normal), _dot(after[:, VELOCITY], normal)
        scattered_out = np.clip(out * bounce, 0, np.maximum(into, out))
        change = after - before
        along = change[:, VELOCITY] - _dot(change[:, VELOCITY], normal)[:, None] * normal
        slip = before[:, VELOCITY] - _dot(before[:, VELOCITY], normal)[:, None] * normal
        slip = slip - BALL_RADIUS * np.cross(before[:, SPIN], normal)
        rolling, impulse = ROLLING * np.linalg.norm(slip, axis=1), np.linalg.norm(along, axis=1)
        most_grip = np.maximum(rolling / np.maximum(impulse, 1e-12), 1.0)  # after it a ball rolls
        extra = np.minimum(grip, most_grip) - 1
        scattered = after.copy()
        scattered[:, VELOCITY] += extra[:, None] * along + (scattered_out - out)[:, None] * normal
        scattered[:, SPIN] += extra[:, None] * change[:, SPIN]
        return scattered


def table_normals(simulator: Simulator, positions: Floats) -> Floats:
    """Return the (B, 3) unit normals from the table to balls at (B, 3); edges included."""
    tilt = simulator.effects.get("table_tilt", {"x": 0.0, "y": 0.0})
    height = simulator.effects.get("table_height", {"h": 0.0})["h"]
    up = np.array([np.sin(tilt["x"]), np.sin(tilt["y"]), 1.0])
    up /= np.linalg.norm(up)
    above = positions @ up - up[2] * height
    nearest = positions - above[:, None] * up
    nearest[:, 0] = nearest[:, 0].clip(-TABLE_HALF_WIDTH, TABLE_HALF_WIDTH)
    nearest[:, 1] = nearest[:, 1].clip(-TABLE_HALF_LENGTH, TABLE_HALF_LENGTH)
    nearest[:, 2] = height - nearest[:, :2] @ up[:2] / up[2]
    away = positions - nearest
    return away / np.linalg.norm(away, axis=1, keepdims=True)


def _dot(a: Floats, b: Floats) -> Floats:
    return np.einsum("ij,ij->i", a, b)
