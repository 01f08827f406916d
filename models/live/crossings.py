"""When a forecast ball meets the table, stops rising, or crosses a plane.

Each is the first change of sign of a quantity along a path whose rows are a few milliseconds apart.
The error of the time is that of the quantity over its rate of change.
"""

from dataclasses import dataclass

import numpy as np

from rallygap.models.ball.state import BALL_RADIUS, POSITION, STATE_SIZE, VELOCITY
from rallygap.models.ball.types import Bools, Floats
from rallygap.models.predictors.sensor import Sensor

GRAVITY = 9.81  # m/s^2; only within a step of a path, and for the error of an apex
NEAR_TABLE = 0.15  # m, height below which a ball that turns upwards has bounced


@dataclass(frozen=True)
class Crossing:
    """Where a quantity changes its sign on a path.

    Attributes:
        row: of the path, before it.
        after: s from that row.
        state: (9,) position (m), velocity (m/s) and spin (rad/s) then, before a contact.
        gradient: (9,) of the quantity, by the state.
        rate: of change of the quantity, 1/s.
    """

    row: int
    after: float
    state: Floats
    gradient: Floats
    rate: float

    def time_error(self, covariance: Floats) -> float:
        """Return the standard deviation of the time, s, by the (9, 9) covariance of the state."""
        variance = float(self.gradient @ covariance @ self.gradient)
        return float(np.sqrt(variance)) / max(abs(self.rate), 1e-3)


def bounce(states: Floats, sensor: Sensor) -> Crossing | None:
    """Return the next contact with the table of a ball; None without any.

    Args:
        states: (T, 9) of the ball, as they would be measured.
        sensor: that measures them; it knows where the table is in its coordinates.
    """
    height, rise = states[:, 2], states[:, 5]
    k = _first((rise[:-1] < 0) & (rise[1:] > 0) & (height[:-1] < NEAR_TABLE))
    if k is None:
        return None
    true_height = float(sensor.true_positions(states[k, POSITION])[2])
    above, fall = max(true_height - BALL_RADIUS, 0.0), -float(rise[k])
    after = (np.sqrt(fall**2 + 2 * GRAVITY * above) - fall) / GRAVITY
    state = states[k].copy()
    state[POSITION] += after * state[VELOCITY]
    state[2], state[5] = height[k] - above, rise[k] - GRAVITY * after
    return Crossing(k, float(after), state, np.eye(STATE_SIZE)[2], float(state[5]))


def apex(states: Floats, step: float) -> Crossing | None:
    """Return where a ball with (T, 9) states, ``step`` s apart, next stops rising."""
    rise = states[:, 5]
    k = _first((rise[:-1] > 0) & (rise[1:] <= 0))
    if k is None:
        return None
    return _between(states, k, rise, step, np.eye(STATE_SIZE)[5], -GRAVITY)


def plane(states: Floats, step: float, point: Floats, normal: Floats) -> Crossing | None:
    """Return where a ball with (T, 9) states, ``step`` s apart, next crosses a plane.

    Args:
        states: of the ball.
        step: s.
        point: (3,) m, of the plane.
        normal: (3,) of the plane, of any length.
    """
    unit = normal / np.linalg.norm(normal)
    side = (states[:, POSITION] - point) @ unit
    k = _first((side[:-1] != 0) & (side[:-1] * side[1:] <= 0))
    if k is None:
        return None
    gradient = np.zeros(STATE_SIZE)
    gradient[POSITION] = unit
    return _between(states, k, side, step, gradient, float(states[k, VELOCITY] @ unit))


def _first(mask: Bools) -> int | None:
    rows = np.flatnonzero(mask)
    return int(rows[0]) if len(rows) else None


def _between(
    states: Floats, k: int, quantity: Floats, step: float, gradient: Floats, rate: float
) -> Crossing:
    share = float(quantity[k] / (quantity[k] - quantity[k + 1]))
    state = (1 - share) * states[k] + share * states[k + 1]
    return Crossing(k, share * step, state, gradient, rate)
