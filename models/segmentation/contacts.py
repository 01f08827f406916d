"""A contact between two arcs: time, position, velocities, and the kind of surface."""

import math
from dataclasses import dataclass

import numpy as np

from rallygap.models.ball.state import BALL_RADIUS, NET_HEIGHT
from rallygap.models.ball.types import Floats
from rallygap.models.segmentation.flight import predict_mean

# A bounce on a horizontal surface reverses the vertical velocity and adds no energy; Coulomb
# friction limits the tangential velocity change (mu is 0.15 to 0.35 on tables).
FRICTION = 0.5
SPEED_ERROR = 1.0  # m/s, of an arc of three samples
# Measured heights of the table are off by up to 3 cm.
TABLE_TOLERANCE = 0.06  # m
# Strokes are played above, the floor is 0.76 m below the table.
FLOOR_HEIGHT = -0.5  # m
NET_TOLERANCE = 0.15  # m, along the table
TAPE_TOLERANCE = 0.05  # m, along the table and in height
MIN_SPEED_CHANGE = 0.5  # m/s, at the table or at the net

NEWTON_STEPS = 5  # the paths are almost straight: two suffice
MIN_RELATIVE_SPEED = 1e-3  # m/s, keeps the step finite where two paths are equal


@dataclass(frozen=True)
class Contact:
    """The closest approach of two consecutive arcs."""

    time: float  # s
    position: Floats  # (3,), m
    before: Floats  # velocity (3,) just before, m/s
    after: Floats  # velocity (3,) just after, m/s
    distance: float  # of the two paths at that time, m

    @property
    def speed_change(self) -> float:
        """Magnitude of the change of velocity, m/s."""
        return float(np.linalg.norm(self.after - self.before))

    @property
    def kind(self) -> str:
        """The surface: ``table``, ``floor``, ``racket``, ``net`` or ``unknown``."""
        if self._bounces():
            if abs(self.position[2] - BALL_RADIUS) < TABLE_TOLERANCE:
                return "table"
            if self.position[2] < FLOOR_HEIGHT:
                return "floor"
        low = self.position[2] < NET_HEIGHT + 2 * BALL_RADIUS
        at_net = low and abs(self.position[1]) < NET_TOLERANCE
        # A ball reverses along the table, away from the net, or gains speed only at a racket.
        turns = self.before[1] * self.after[1] < 0 and abs(self.after[1]) > SPEED_ERROR
        gain = float(np.linalg.norm(self.after) - np.linalg.norm(self.before))
        if (turns and not at_net) or gain > SPEED_ERROR:
            return "racket"
        return "net" if at_net else "unknown"

    @property
    def is_grazing(self) -> bool:
        """Whether it is a light contact with the table or the net, the only plausible ones."""
        reverses = self.kind == "table" and self.before[2] < 0 < self.after[2]
        height = self.position[2] - NET_HEIGHT
        at_tape = max(abs(self.position[1]), abs(height)) < TAPE_TOLERANCE
        return bool(self.speed_change > MIN_SPEED_CHANGE and (reverses or at_tape))

    def _bounces(self) -> bool:
        """Whether a passive horizontal surface with Coulomb friction can cause the change."""
        change = self.after - self.before
        downwards, upwards = -self.before[2], self.after[2]
        along = math.hypot(change[0], change[1])
        return bool(
            min(downwards, upwards) > -SPEED_ERROR
            and upwards < downwards + SPEED_ERROR
            and along < FRICTION * change[2] + SPEED_ERROR
        )


def closest_approach(
    before: tuple[Floats, float], after: tuple[Floats, float], earliest: float, latest: float
) -> Contact:
    """Find where two paths are closest to each other.

    Args:
        before: the earlier path's state (3, 3) and its time (s), near the end.
        after: the later path's state and its time, near the start.
        earliest: lower bound of the time, s.
        latest: upper bound of the time, s.
    """

    def states(time: float) -> tuple[Floats, Floats]:
        early, late = (extrapolated(mean, time - since) for mean, since in (before, after))
        return early, late

    time = 0.5 * (earliest + latest)
    for _ in range(NEWTON_STEPS):
        early, late = states(time)
        offset, relative = early[0] - late[0], early[1] - late[1]
        time -= float(offset @ relative) / max(float(relative @ relative), MIN_RELATIVE_SPEED**2)
        time = min(max(time, earliest), latest)
    early, late = states(time)
    distance = float(np.linalg.norm(early[0] - late[0]))
    return Contact(time, 0.5 * (early[0] + late[0]), early[1], late[1], distance)


def extrapolated(mean: Floats, dt: float) -> Floats:
    """Return the state (3, 3) ``dt`` seconds later."""
    copy = mean.copy()
    predict_mean(copy, dt)
    return copy
