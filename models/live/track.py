"""The track of one ball: a filter over measurements that may come late, at any times.

Measurements are kept as the sensor gives them. The filter is of the true ball, so it corrects them
by the systematic errors of the simulator's sensor. Predictors read the track's history: its last
measurements on their grid of times.
"""

import numpy as np

from rallygap.models.ball.compose import compiled
from rallygap.models.ball.simulator import Simulator
from rallygap.models.ball.state import STATE_SIZE
from rallygap.models.ball.types import Bools, Floats
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
from rallygap.models.predictors.protocol import HISTORY_TIMES, TICK, History
from rallygap.models.predictors.sensor import Sensor

Belief = tuple[Floats, Floats]  # (9,) mean and (9, 9) covariance

KEPT = 48  # measurements of which a late one can be among; 240 ms at 200 Hz
LONGEST_GAP = 0.3  # s without a measurement, after which a ball is another one
FIRST_SPEED = 15.0  # m/s, standard deviation of a velocity component before the second measurement
FIRST_SPIN = 500.0  # rad/s, of a spin component before the course is known
COURSE_KNOWN = 4  # measurements after which spins about the course can be expected
LONGEST_BRIDGED = 3  # ticks between measurements, across which positions are interpolated
ROUNDING = 0.01  # ticks, by which two times may differ by rounding

# A measurement, and the filtered ball at its time.
ROW = np.dtype(
    [
        ("time", np.float64),
        ("position", np.float64, 3),
        ("true", np.float64, 3),  # position, corrected
        ("noise", np.float64, (3, 3)),
        ("spin", np.float64, 3),
        ("state", np.float64, STATE_SIZE),
        ("covariance", np.float64, (STATE_SIZE, STATE_SIZE)),
    ]
)


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
        self._rows = np.empty(0, ROW)  # at most KEPT, in the order of their times

    @property
    def last(self) -> float:
        """Time of the last measurement that was used, s; minus infinity before the first one."""
        return float(self._rows["time"][-1]) if len(self._rows) else -np.inf

    @property
    def state(self) -> Floats:
        """(9,) mean at the last measurement, of the true ball."""
        return self._rows["state"][-1]

    @property
    def covariance(self) -> Floats:
        """(9, 9) covariance at the last measurement."""
        return self._rows["covariance"][-1]

    @property
    def times(self) -> Floats:
        """(K,) s, of the latest measurements that were used."""
        return self._rows["time"]

    @property
    def positions(self) -> Floats:
        """(K, 3) m, of these, as measured."""
        return self._rows["position"]

    @property
    def spins(self) -> Floats:
        """(K, 3) rad/s, of these, as measured; NaN where not measured."""
        return self._rows["spin"]

    def add(self, t: float, position: Floats, noise: Floats, spin: Floats) -> bool:
        """Use a measurement unless it is an outlier or too late; return whether it was used.

        A late measurement is filtered where it belongs, and those after it again.

        Args:
            t: s, of the sensor's clock.
            position: (3,) m.
            noise: (3, 3) m^2, its covariance.
            spin: (3,) rad/s, NaN if it was not measured.
        """
        rows = self._rows
        place = int(np.searchsorted(self.times, t))
        known = place < len(rows) and self.times[place] == t
        lost = place == len(rows) > 0 and t - self.last > LONGEST_GAP
        if known or lost or (place == 0 and len(rows)):
            return False
        true = self._sensor.true_positions(position)
        guess = self._reached(place - 1, t) if place else _first_guess(true, noise, spin)
        if place and distance(*guess, true, noise) >= OUTLIER_DISTANCE:
            return False
        dropped = int(len(rows) == KEPT)  # the oldest one
        row = np.array([(t, position, true, noise, spin, *guess)], ROW)
        # As plain numbers, which NumPy copies faster than fields.
        parts = [part.view(np.float64) for part in (rows[dropped:place], row, rows[place:])]
        self._rows = np.concatenate(parts).view(ROW)
        self.count += 1
        place -= dropped
        self._filter(place, guess)
        for k in range(place + 1, len(self._rows)):
            self._filter(k, self._reached(k - 1, self.times[k]))
        return True

    def _reached(self, k: int, t: float) -> Belief:
        """Return what is known at a time after the k-th measurement, in steps of a tick."""
        since, x, P = (self._rows[name][k] for name in ("time", "state", "covariance"))
        span = (t - since) / self._sensor.clock
        steps = max(int(np.ceil(span / TICK - 1e-9)), 1)
        for _ in range(steps):
            x, P = advanced(x, P, span / steps, self._parameters)
        return x, P

    def _filter(self, k: int, guess: Belief) -> None:
        """Compute the state at the k-th measurement from what is known before it."""
        row = self._rows[k]
        x, P = updated(*guess, row["true"], 0, row["noise"])
        if np.isfinite(row["spin"][0]):
            spin = self._sensor.true_spins(row["spin"])
            x, P = updated(x, P, spin, 6, label_noise(spin))
        elif (
            k + self.count - len(self._rows) == COURSE_KNOWN
            and not np.isfinite(self.spins[:k, 0]).any()
        ):
            # The course is known from now on; the expected spin counts as if it were measured.
            axes = course_axes(x[3:6])
            covariance = (axes * np.square(self._expected.spin_spread)) @ axes.T
            x, P = updated(x, P, axes @ np.array(self._expected.spin), 6, covariance)
        row["state"], row["covariance"] = x, P


def _first_guess(position: Floats, noise: Floats, spin: Floats) -> Belief:
    """Return what is known before the first measurement: it is somewhere near, and may be fast."""
    x = np.zeros(STATE_SIZE)
    x[:3] = position
    size = float(np.linalg.norm(spin)) if np.isfinite(spin[0]) else 0.0
    spread = np.repeat([np.sqrt(np.trace(noise)), FIRST_SPEED, max(FIRST_SPIN, size)], 3)
    return x, np.diag(spread**2)


def history_of(track: Track) -> History:
    """Return the history that ends at a track's last measurement.

    Positions are interpolated between the measurements on either side; those in longer gaps, and
    before the first measurement, count as not measured. A spin label belongs to the nearest time.

    Args:
        track: with one measurement or more.
    """
    times, positions = np.ascontiguousarray(track.times), np.ascontiguousarray(track.positions)
    states, mask = _on_grid(times, positions, np.ascontiguousarray(track.spins), HISTORY_TIMES)
    return History(states, mask)


@compiled
def _on_grid(times: Floats, positions: Floats, spins: Floats, grid: Floats) -> tuple[Floats, Bools]:
    """Return (1, 12, 6) states, and where there are any, at times before the last measurement."""
    count, tick, last = len(grid), grid[-1] - grid[-2], times[-1]
    states, mask = np.zeros((1, count, 6)), np.zeros((1, count, 6), dtype=np.bool_)
    same, longest = ROUNDING * tick, LONGEST_BRIDGED * tick
    for k in range(count):
        t = last + grid[k]
        after = np.searchsorted(times, t - same)
        if abs(times[after] - t) < same:
            states[0, k, :3], mask[0, k, :3] = positions[after], True
        elif after > 0 and times[after] - times[after - 1] <= longest:
            share = (t - times[after - 1]) / (times[after] - times[after - 1])
            states[0, k, :3] = (1 - share) * positions[after - 1] + share * positions[after]
            mask[0, k, :3] = True
    for n in range(len(times)):
        place = count - 1 + round((times[n] - last) / tick)
        if place >= 0 and np.isfinite(spins[n, 0]):
            states[0, place, 3:], mask[0, place, 3:] = spins[n], True
    return states, mask
