"""The track of one ball: a filter over measurements that may come late, at any times.

Measurements are kept as the sensor gives them. The filter is of the true ball, so it corrects them
by the systematic errors of the simulator's sensor.
"""

import numpy as np

from rallygap.models.ball.simulator import Simulator
from rallygap.models.ball.state import STATE_SIZE
from rallygap.models.ball.types import Floats
from rallygap.models.predictors.ball_filter import (
    ANY_BALL,
    OUTLIER_DISTANCE,
    Expected,
    advanced,
    course_axes,
    distance,
    label_noise,
    updated,
)
from rallygap.models.predictors.protocol import TICK
from rallygap.models.predictors.sensor import Sensor

Belief = tuple[Floats, Floats]  # (9,) mean and (9, 9) covariance

KEPT = 48  # measurements of which a late one can be among; 240 ms at 200 Hz
LONGEST_GAP = 0.3  # s without a measurement, after which a ball is another one
FIRST_SPEED = 15.0  # m/s, standard deviation of a velocity component before the second measurement
FIRST_SPIN = 500.0  # rad/s, of a spin component before the course is known
COURSE_KNOWN = 4  # measurements after which spins about the course can be expected


class Track:
    """Filters the measurements of one ball.

    Args:
        simulator: of the ball and of the sensor.
        expected: of the balls; their spin is that of a ball without a label.

    Attributes:
        count: of measurements that were used.
    """

    def __init__(self, simulator: Simulator, expected: Expected = ANY_BALL) -> None:
        self._parameters, self._sensor = simulator.vector, Sensor(simulator)
        self._expected = expected
        self.count = 0
        self._size = 0
        self._times = np.empty(KEPT)
        self._positions = np.empty((KEPT, 3))
        self._true = np.empty((KEPT, 3))  # positions, corrected
        self._noises = np.empty((KEPT, 3, 3))
        self._spins = np.empty((KEPT, 3))
        self._states = np.empty((KEPT, STATE_SIZE))
        self._covariances = np.empty((KEPT, STATE_SIZE, STATE_SIZE))

    @property
    def last(self) -> float:
        """Time of the last measurement that was used, s; minus infinity before the first one."""
        return float(self._times[self._size - 1]) if self._size else -np.inf

    @property
    def state(self) -> Floats:
        """(9,) mean at the last measurement, of the true ball."""
        state: Floats = self._states[self._size - 1]
        return state

    @property
    def covariance(self) -> Floats:
        """(9, 9) covariance at the last measurement."""
        covariance: Floats = self._covariances[self._size - 1]
        return covariance

    @property
    def times(self) -> Floats:
        """(K,) s, of the latest measurements that were used."""
        return self._times[: self._size]

    @property
    def positions(self) -> Floats:
        """(K, 3) m, of these, as measured."""
        return self._positions[: self._size]

    @property
    def spins(self) -> Floats:
        """(K, 3) rad/s, of these, as measured; NaN where not measured."""
        return self._spins[: self._size]

    def add(self, t: float, position: Floats, noise: Floats, spin: Floats) -> bool:
        """Use a measurement unless it is an outlier or too late; return whether it was used.

        A late measurement is filtered where it belongs, and those after it again.

        Args:
            t: s, of the sensor's clock.
            position: (3,) m.
            noise: (3, 3) m^2, its covariance.
            spin: (3,) rad/s, NaN if it was not measured.
        """
        place = int(np.searchsorted(self.times, t))
        known = place < self._size and self._times[place] == t
        lost = place == self._size > 0 and t - self.last > LONGEST_GAP
        if known or lost or (place == 0 and self._size):
            return False
        true = self._sensor.true_positions(position)
        guess = self._reached(place - 1, t) if place else _first_guess(true, noise, spin)
        if place and distance(*guess, true, noise) >= OUTLIER_DISTANCE:
            return False
        place = self._insert(place, (t, position, true, noise, spin))
        self.count += 1
        self._filter(place, guess)
        for k in range(place + 1, self._size):
            self._filter(k, self._reached(k - 1, self._times[k]))
        return True

    def _reached(self, k: int, t: float) -> Belief:
        """Return what is known at a time after the k-th measurement, in steps of a tick."""
        x, P = self._states[k], self._covariances[k]
        span = (t - self._times[k]) / self._sensor.clock
        steps = max(int(np.ceil(span / TICK - 1e-9)), 1)
        for _ in range(steps):
            x, P = advanced(x, P, span / steps, self._parameters)
        return x, P

    def _insert(self, place: int, row: tuple[float | Floats, ...]) -> int:
        """Make room for a measurement, by dropping the oldest one if need be; return its place."""
        if self._size == KEPT:
            for rows in (*self._rows, self._states, self._covariances):
                rows[:-1] = rows[1:]
            place -= 1
        else:
            self._size += 1
        for rows, value in zip(self._rows, row, strict=True):
            rows[place + 1 : self._size] = rows[place : self._size - 1].copy()
            rows[place] = value
        return place

    @property
    def _rows(self) -> tuple[Floats, ...]:
        return self._times, self._positions, self._true, self._noises, self._spins

    def _filter(self, k: int, guess: Belief) -> None:
        """Compute the state at the k-th measurement from what is known before it."""
        x, P = updated(*guess, self._true[k], 0, self._noises[k])
        if np.isfinite(self._spins[k, 0]):
            spin = self._sensor.true_spins(self._spins[k])
            x, P = updated(x, P, spin, 6, label_noise(spin))
        elif self._expects_spin(k):
            x, P = updated(x, P, *_expected_spin(x, self._expected))
        self._states[k], self._covariances[k] = x, P

    def _expects_spin(self, k: int) -> bool:
        """Whether the k-th measurement makes the course known, of a ball without a label so far."""
        since_first = k + self.count - self._size
        return since_first == COURSE_KNOWN and not np.isfinite(self._spins[:k, 0]).any()


def _first_guess(position: Floats, noise: Floats, spin: Floats) -> Belief:
    """Return what is known before the first measurement: it is somewhere near, and may be fast."""
    x = np.zeros(STATE_SIZE)
    x[:3] = position
    size = float(np.linalg.norm(spin)) if np.isfinite(spin[0]) else 0.0
    spread = np.repeat([np.sqrt(np.trace(noise)), FIRST_SPEED, max(FIRST_SPIN, size)], 3)
    return x, np.diag(spread**2)


def _expected_spin(x: Floats, expected: Expected) -> tuple[Floats, int, Floats]:
    """Return the spin that a ball of a state is expected to have, as if it were measured."""
    axes = course_axes(x[3:6])
    covariance = (axes * np.square(expected.spin_spread)) @ axes.T
    return axes @ np.array(expected.spin), 6, covariance
