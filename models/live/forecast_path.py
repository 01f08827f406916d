"""A forecast path, and what happens to the ball on it."""

from dataclasses import dataclass

import numpy as np

from models.ball.state import BALL_RADIUS, POSITION, VELOCITY
from models.ball.types import Floats

UP = np.array([0.0, 0.0, 1.0])
GRAVITY = 9.81  # m/s^2, only within a step of a path
NEAR_TABLE = 0.15  # m, height below which a ball that turns upwards has bounced


@dataclass(frozen=True)
class Event:
    """Something that happens to a ball.

    Attributes:
        time: s, of the sensor's clock.
        time_error: s, its standard deviation.
        state: (9,) position (m), velocity (m/s) and spin (rad/s), before a contact.
        covariance: (9, 9) of the state at this time.
    """

    time: float
    time_error: float
    state: Floats
    covariance: Floats


@dataclass(frozen=True)
class ForecastPath:
    """A forecast at rising times, a few milliseconds apart.

    Attributes:
        times: (T,) s, of the sensor's clock.
        states: (T, 9) means.
        covariances: (T, 9, 9) of these.
    """

    times: Floats
    states: Floats
    covariances: Floats

    def bounce(self) -> Event | None:
        """Return the next contact with the table; None if there is none on the path."""
        height, rise = self.states[:, 2], self.states[:, 5]
        turned = np.flatnonzero((rise[:-1] < 0) & (rise[1:] > 0) & (height[:-1] < NEAR_TABLE))
        if not len(turned):
            return None
        k = int(turned[0])
        above, fall = max(height[k] - BALL_RADIUS, 0.0), -rise[k]
        after = (np.sqrt(fall**2 + 2 * GRAVITY * above) - fall) / GRAVITY
        state = self.states[k].copy()
        state[POSITION] += after * state[VELOCITY]
        state[2], state[5] = BALL_RADIUS, rise[k] - GRAVITY * after
        return self._event(k, float(after), state, UP)

    def apex(self) -> Event | None:
        """Return where the ball next stops rising; None if it does not on the path."""
        rise = self.states[:, 5]
        turned = np.flatnonzero((rise[:-1] > 0) & (rise[1:] <= 0))
        if not len(turned):
            return None
        k = int(turned[0])
        share = float(rise[k] / (rise[k] - rise[k + 1]))
        state, covariance = self._between(k, share), self.covariances[k]
        after = share * (self.times[k + 1] - self.times[k])
        error = float(np.sqrt(covariance[5, 5])) / GRAVITY
        return Event(float(self.times[k] + after), error, state, covariance)

    def crossing(self, point: Floats, normal: Floats) -> Event | None:
        """Return where the ball next crosses a plane, from either side; None if it does not.

        Args:
            point: (3,) m, of the plane.
            normal: (3,) of the plane, of any length.
        """
        unit = normal / np.linalg.norm(normal)
        side = (self.states[:, POSITION] - point) @ unit
        crossed = np.flatnonzero((side[:-1] != 0) & (side[:-1] * side[1:] <= 0))
        if not len(crossed):
            return None
        k = int(crossed[0])
        share = float(side[k] / (side[k] - side[k + 1]))
        after = share * float(self.times[k + 1] - self.times[k])
        return self._event(k, after, self._between(k, share), unit)

    def _between(self, k: int, share: float) -> Floats:
        state: Floats = (1 - share) * self.states[k] + share * self.states[k + 1]
        return state

    def _event(self, k: int, after: float, state: Floats, normal: Floats) -> Event:
        """Return the event ``after`` seconds after row k, where a surface of a normal is met."""
        covariance = self.covariances[k]
        error = np.sqrt(normal @ covariance[POSITION, POSITION] @ normal)
        speed = max(abs(float(normal @ state[VELOCITY])), 1e-3)
        return Event(float(self.times[k] + after), float(error) / speed, state, covariance)
