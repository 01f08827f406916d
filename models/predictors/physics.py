"""The physics predictor: an extended Kalman filter over the history, then a simulator.

The paper's physics baseline. The filter's state is position, velocity and spin. Its motion model is
the simulator, bounces included, with a numerical Jacobian. A ball without a spin label starts with
a wide prior on spin, so that only the curvature of the path informs it; the forecast says that the
spin was not measured.
"""

import numpy as np
from filterpy.kalman import ExtendedKalmanFilter
from numpy.typing import NDArray

from models.ball.simulator import Simulator
from models.ball.state import POSITION, SPIN, STATE_SIZE, VELOCITY
from models.predictors.protocol import FUTURE_TIMES, TICK, Bools, Floats, Forecast, History

# Measurement noise: 3 mm and 5 % of the spin in the paper; up to 4.4 mm in real data sets.
POSITION_NOISE = 0.004  # m
SPIN_NOISE_SHARE = 0.05  # of the spin
SPIN_NOISE_FLOOR = 5.0  # rad/s

# Prior before the first measurement.
FIRST_SAMPLES = 4  # samples whose slopes give the initial velocity
VELOCITY_PRIOR = 5.0  # m/s; wide enough for a bounce among these samples
SPIN_PRIOR = 150.0  # rad/s, where the spin is not labelled

# Process noise: errors of the simulator in one tick.
ACCELERATION_NOISE = 2.0  # m/s^2
SPIN_DRIFT = 1.0  # rad/s

# A position whose squared Mahalanobis distance exceeds this is an outlier (3 degrees of freedom,
# one in 10^5).
OUTLIER_DISTANCE = 25.9
# A restart of the filter counts as much as this many outliers. One true outlier makes up to three:
# lost samples on either side are interpolated towards it.
RESTART_PENALTY = 3

# Steps of the numerical Jacobian: m, m/s, rad/s.
_STEPS = np.repeat([1e-5, 1e-3, 1e-1], 3)
_PROBES = np.vstack([np.zeros(STATE_SIZE), np.diag(_STEPS), -np.diag(_STEPS)])


class _BallFilter(ExtendedKalmanFilter):
    """filterpy's filter with a simulator as its motion model, in the usual symbols."""

    def __init__(self, simulator: Simulator, x: Floats, P: Floats) -> None:
        super().__init__(dim_x=STATE_SIZE, dim_z=3)
        self.simulator = simulator
        self.x, self.P = x, P
        G = ACCELERATION_NOISE**2 * np.array([TICK**4 / 4, TICK**3 / 2, TICK**2])
        q = np.kron(np.array([[G[0], G[1]], [G[1], G[2]]]), np.eye(3))
        self.Q = np.zeros((STATE_SIZE, STATE_SIZE))
        self.Q[:6, :6] = q
        self.Q[SPIN, SPIN] = SPIN_DRIFT**2 * np.eye(3)

    def predict_x(self, u: object = 0) -> None:
        """Move the mean by one tick, and linearise the motion about it."""
        reached = self.simulator.fly(self.x + _PROBES, [TICK]).states[:, 0]
        above, below = reached[1 : STATE_SIZE + 1], reached[STATE_SIZE + 1 :]
        self.F = ((above - below) / (2 * _STEPS[:, None])).T
        self.x = reached[0]

    def update_position(self, position: Floats) -> bool:
        """Update with a measured position unless it is an outlier; return whether it was used."""
        R = POSITION_NOISE**2 * np.eye(3)
        y = position - self.x[POSITION]
        S = self.P[POSITION, POSITION] + R
        expected = bool(y @ np.linalg.solve(S, y) < OUTLIER_DISTANCE)
        if expected:
            self._update(position, POSITION, R)
        return expected

    def update_spin(self, spin: Floats) -> None:
        """Update with a spin label."""
        noise = SPIN_NOISE_SHARE * float(np.linalg.norm(spin)) + SPIN_NOISE_FLOOR
        self._update(spin, SPIN, noise**2 * np.eye(3))

    def _update(self, z: Floats, part: slice, R: Floats) -> None:
        H = np.eye(STATE_SIZE)[part]
        self.update(z, lambda _: H, lambda x: x[part], R=R)


class PhysicsPredictor:
    """Filters the history and simulates the flight from the filtered state."""

    def __init__(self, simulator: Simulator) -> None:
        self.simulator = simulator

    def predict(self, history: History) -> Forecast:
        """Forecast each ball; one without any measurement is forecast at the table's centre."""
        rows = zip(history.states, history.mask, strict=True)
        now = np.array([self._filtered(states, mask) for states, mask in rows])
        flown = self.simulator.fly(now.reshape(-1, STATE_SIZE), FUTURE_TIMES).states
        return Forecast(flown, history.spin_measured)

    def _filtered(self, states: Floats, mask: Bools) -> Floats:
        """Return the (9,) state at the last of (12, 6) measurements.

        An outlier among the first measurements, or a wrongly simulated contact, can make the
        filter reject all later measurements; restarting it at one of them recovers the ball, but
        restarting at a true outlier loses it. So every path through the history costs its number
        of outliers plus ``RESTART_PENALTY`` a restart, and the cheapest path wins.
        """
        now, cheapest = np.zeros(STATE_SIZE), np.inf
        placed = np.flatnonzero(mask[:, :3].all(axis=1)).tolist()
        costs = dict.fromkeys(placed[:1], 0)  # by start: the cost up to it
        for start in placed:
            if costs.get(start, np.inf) >= cheapest:
                continue
            reached, outliers = self._tracked(states, mask, start)
            if costs[start] + len(outliers) < cheapest:
                now, cheapest = reached, costs[start] + len(outliers)
            for earlier, outlier in enumerate(outliers):
                cost = costs[start] + earlier + RESTART_PENALTY
                costs[outlier] = min(cost, costs.get(outlier, cost))
        return now

    def _tracked(self, states: Floats, mask: Bools, start: int) -> tuple[Floats, list[int]]:
        """Filter from ``start``; return the last state and the rows of the outliers."""
        ball = _BallFilter(self.simulator, *_first_guess(states[start:], mask[start:]))
        outliers = []
        for k in range(start, len(states)):
            if k > start:
                ball.predict()
            if mask[k, :3].all() and not ball.update_position(states[k, :3]):
                outliers.append(k)
            if mask[k, 3:].all():
                ball.update_spin(states[k, 3:])
        return ball.x, outliers


def _first_guess(states: Floats, mask: Bools) -> tuple[Floats, Floats]:
    """Return mean and covariance at the first measurement, whose position is known."""
    first = np.flatnonzero(mask[:, :3].all(axis=1))[:FIRST_SAMPLES]
    x = np.zeros(STATE_SIZE)
    x[POSITION] = states[0, :3]
    x[VELOCITY] = _median_slope(first * TICK, states[first, :3])
    labelled = np.flatnonzero(mask[:, 3:].all(axis=1))
    spread = np.repeat([10 * POSITION_NOISE, VELOCITY_PRIOR, SPIN_PRIOR], 3)
    if len(labelled):
        x[SPIN] = states[labelled[0], 3:]
        spread[SPIN] = max(SPIN_PRIOR, float(np.linalg.norm(x[SPIN])))
    return x, np.diag(spread**2)


def _median_slope(times: NDArray[np.floating], positions: Floats) -> Floats:
    """Return the median slope over all pairs, robust to one outlier; zero for one point."""
    left, right = np.triu_indices(len(times), k=1)
    if not len(left):
        return np.zeros(3)
    slopes = (positions[right] - positions[left]) / (times[right] - times[left])[:, None]
    return np.median(slopes, axis=0)
