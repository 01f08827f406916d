"""The track of one ball: a filter over measurements that may come late, at any times."""

import numpy as np

from models.ball.simulator import Simulator
from models.ball.state import STATE_SIZE
from models.ball.types import Floats
from models.predictors.ball_filter import (
    OUTLIER_DISTANCE,
    SPIN_PRIOR,
    advanced,
    distance,
    label_noise,
    updated,
)
from models.predictors.protocol import TICK

Belief = tuple[Floats, Floats]  # (9,) mean and (9, 9) covariance

KEPT = 48  # measurements of which a late one can be among; 240 ms at 200 Hz
LONGEST_GAP = 0.3  # s without a measurement, after which a ball is another one
FIRST_SPEED = 15.0  # m/s, standard deviation of a velocity component before the second measurement


class Track:
    """Filters the measurements of one ball.

    Attributes:
        count: of measurements that were used.
    """

    def __init__(self, simulator: Simulator) -> None:
        self._parameters = simulator.vector
        self.count = 0
        self._size = 0
        self._times = np.empty(KEPT)
        self._positions = np.empty((KEPT, 3))
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
        """(9,) mean at the last measurement."""
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
        """(K, 3) m, of these."""
        return self._positions[: self._size]

    @property
    def spins(self) -> Floats:
        """(K, 3) rad/s, of these; NaN where not measured."""
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
        guess = self._reached(place - 1, t) if place else _first_guess(position, noise, spin)
        if place and distance(*guess, position, noise) >= OUTLIER_DISTANCE:
            return False
        place = self._insert(place, t, position, noise, spin)
        self._filter(place, guess)
        for k in range(place + 1, self._size):
            self._filter(k, self._reached(k - 1, self._times[k]))
        self.count += 1
        return True

    def _reached(self, k: int, t: float) -> Belief:
        """Return what is known at a time after the k-th measurement, in steps of a tick."""
        x, P = self._states[k], self._covariances[k]
        steps = max(int(np.ceil((t - self._times[k]) / TICK - 1e-9)), 1)
        dt = (t - self._times[k]) / steps
        for _ in range(steps):
            x, P = advanced(x, P, dt, self._parameters)
        return x, P

    def _insert(self, place: int, t: float, position: Floats, noise: Floats, spin: Floats) -> int:
        """Make room for a measurement, by dropping the oldest one if need be; return its place."""
        measured: tuple[Floats, ...] = (self._times, self._positions, self._noises, self._spins)
        if self._size == KEPT:
            for rows in (*measured, self._states, self._covariances):
                rows[:-1] = rows[1:]
            place -= 1
        else:
            self._size += 1
        for rows in measured:
            rows[place + 1 : self._size] = rows[place : self._size - 1].copy()
        self._times[place], self._positions[place] = t, position
        self._noises[place], self._spins[place] = noise, spin
        return place

    def _filter(self, k: int, guess: Belief) -> None:
        """Compute the state at the k-th measurement from what is known before it."""
        x, P = updated(*guess, self._positions[k], 0, self._noises[k])
        spin = self._spins[k]
        if np.isfinite(spin[0]):
            x, P = updated(x, P, spin, 6, label_noise(spin))
        self._states[k], self._covariances[k] = x, P


def _first_guess(position: Floats, noise: Floats, spin: Floats) -> Belief:
    """Return what is known before the first measurement: it is somewhere near, and may be fast."""
    x = np.zeros(STATE_SIZE)
    x[:3] = position
    size = np.linalg.norm(spin) if np.isfinite(spin[0]) else 0.0
    spread = np.repeat([np.sqrt(np.trace(noise)), FIRST_SPEED, max(SPIN_PRIOR, float(size))], 3)
    return x, np.diag(spread**2)
