"""A contact: where the paths of two arcs meet, and what the ball met there."""

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from models.ball.state import BALL_RADIUS, NET_HEIGHT
from models.segmentation.flight import drift

Array = NDArray[np.float64]

# A bounce, on whatever level surface: it turns the ball upwards and gives no energy, and friction
# takes no more along the surface than a share of the blow (mu is 0.15 to 0.35 on tables).
FRICTION = 0.5
SPEED_ERROR = 1.0  # m/s, of an arc of three samples
# Measured heights of the table are off by up to 3 cm.
TABLE_TOLERANCE = 0.06  # m
# Strokes are played above, floors lie 0.76 m below the table.
FLOOR_HEIGHT = -0.5  # m
NET_TOLERANCE = 0.15  # m, along the table
TAPE_TOLERANCE = 0.05  # m, along the table and in height
SLIGHTEST_TOUCH = 0.5  # m/s, where there is something to touch

NEWTON_STEPS = 5  # the paths are almost straight: two are enough
SLOWEST_PARTING = 1e-3  # m/s, keeps the step finite where two paths are the same


@dataclass(frozen=True)
class Contact:
    """Two arcs' meeting.

    Attributes:
        time: s.
        position: (3,), m.
        before: velocity (3,) just before, m/s.
        after: velocity (3,) just after, m/s.
        miss: the least distance between the two paths, m.
    """

    time: float
    position: Array
    before: Array
    after: Array
    miss: float

    @property
    def speed_change(self) -> float:
        """Length of the velocity's change, m/s."""
        return float(np.linalg.norm(self.after - self.before))

    @property
    def kind(self) -> str:
        """What the ball met: ``table``, ``floor``, ``racket`` or ``unknown``."""
        if self._bounces():
            if abs(self.position[2] - BALL_RADIUS) < TABLE_TOLERANCE:
                return "table"
            if self.position[2] < FLOOR_HEIGHT:
                return "floor"
        return "racket" if self._is_struck() else "unknown"

    @property
    def grazes(self) -> bool:
        """Whether something is there that a ball may touch so lightly: the table or the net."""
        turns_up = self.before[2] < 0 < self.after[2]
        skims = self.kind == "table" and turns_up
        height = self.position[2] - NET_HEIGHT
        at_tape = max(abs(self.position[1]), abs(height)) < TAPE_TOLERANCE
        return bool(self.speed_change > SLIGHTEST_TOUCH and (skims or at_tape))

    def _bounces(self) -> bool:
        """Whether a level surface can have done this: it gives no energy, and has friction."""
        change = self.after - self.before
        downwards, upwards = -self.before[2], self.after[2]
        along = math.hypot(change[0], change[1])
        return bool(
            min(downwards, upwards) > -SPEED_ERROR
            and upwards < downwards + SPEED_ERROR
            and along < FRICTION * change[2] + SPEED_ERROR
        )

    def _is_struck(self) -> bool:
        """Whether the ball turns back along the table, or gains speed, as only rackets make it."""
        turns = self.before[1] * self.after[1] < 0 and abs(self.after[1]) > SPEED_ERROR
        gain = float(np.linalg.norm(self.after) - np.linalg.norm(self.before))
        return bool(turns and not self._is_at_net()) or gain > SPEED_ERROR

    def _is_at_net(self) -> bool:
        low = self.position[2] < NET_HEIGHT + 2 * BALL_RADIUS
        return bool(low and abs(self.position[1]) < NET_TOLERANCE)


def meet(
    before: tuple[Array, float], after: tuple[Array, float], earliest: float, latest: float
) -> Contact:
    """Find where two paths come nearest to each other.

    Args:
        before: the earlier path's mean (3, 3) at some time (s) near its end.
        after: the later path's mean at some time near its beginning.
        earliest: the meeting lies no earlier, s.
        latest: nor later, s.
    """
    time = 0.5 * (earliest + latest)
    for _ in range(NEWTON_STEPS):
        early, late = _at(*before, time), _at(*after, time)
        apart, parting = early[0] - late[0], early[1] - late[1]
        time -= float(apart @ parting) / max(float(parting @ parting), SLOWEST_PARTING**2)
        time = min(max(time, earliest), latest)
    early, late = _at(*before, time), _at(*after, time)
    miss = float(np.linalg.norm(early[0] - late[0]))
    return Contact(time, 0.5 * (early[0] + late[0]), early[1], late[1], miss)


def _at(mean: Array, since: float, time: float) -> Array:
    return moved(mean, time - since)


def moved(mean: Array, dt: float) -> Array:
    """Return a copy of ``mean`` moved ``dt`` seconds along its path."""
    copy = mean.copy()
    drift(copy, dt)
    return copy
