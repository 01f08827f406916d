"""The physics predictor with filterpy's extended Kalman filter: the paper's baseline as published.

It filters one ball at a time, sixteen times slower than ``ball_filter.py``, with which it agrees:
the same motion model, prior, noise, outliers and restarts, in another implementation.
"""

import numpy as np
from filterpy.common import Q_discrete_white_noise
from filterpy.kalman import ExtendedKalmanFilter
from scipy.linalg import block_diag

from rallygap.models.ball.simulator import Simulator
from rallygap.models.ball.state import POSITION, SPIN, STATE_SIZE, VELOCITY
from rallygap.models.predictors.ball_filter import (
    ACCELERATION_NOISE,
    FIRST_SAMPLES,
    NOISE_TICK,
    OUTLIER_DISTANCE,
    POSITION_NOISE,
    PROBES,
    RESTART_PENALTY,
    SPIN_DRIFT,
    SPIN_NOISE_FLOOR,
    SPIN_NOISE_SHARE,
    SPIN_PRIOR,
    STEPS,
    VELOCITY_PRIOR,
    Filtered,
)
from rallygap.models.predictors.physics import PhysicsPredictor
from rallygap.models.predictors.protocol import TICK, Bools, Floats, History

WHOLE = np.eye(STATE_SIZE)
NOISE_OF_POSITION = POSITION_NOISE**2 * np.eye(3)


class FilterpyPredictor(PhysicsPredictor):
    """Filters the history with filterpy, whatever balls are expected, and flies on from there."""

    def _now(self, history: History) -> Filtered:
        true, tick = self._sensor.true_history(history), TICK / self._sensor.clock
        return filtered_by_filterpy(true, self.simulator, tick)


def filtered_by_filterpy(history: History, simulator: Simulator, tick: float = TICK) -> Filtered:
    """Filter balls as ``filtered`` does."""
    now = [
        _cheapest(states, mask, simulator, tick)
        for states, mask in zip(history.states, history.mask, strict=True)
    ]
    return Filtered(
        np.array([state for state, _ in now]).reshape(-1, STATE_SIZE),
        np.array([covariance for _, covariance in now]).reshape(-1, STATE_SIZE, STATE_SIZE),
    )


class _BallFilter(ExtendedKalmanFilter):
    """filterpy's filter of one ball with a simulator as its motion model, in the usual symbols."""

    def __init__(self, simulator: Simulator, tick: float, x: Floats, P: Floats) -> None:
        super().__init__(dim_x=STATE_SIZE, dim_z=3)
        self.simulator, self.tick = simulator, tick
        self.x, self.P = x, P
        variance = ACCELERATION_NOISE**2 * NOISE_TICK / tick
        q = Q_discrete_white_noise(2, tick, variance, block_size=3, order_by_dim=False)
        self.Q = block_diag(q, SPIN_DRIFT**2 * tick / NOISE_TICK * np.eye(3))

    def predict_x(self, u: object = 0) -> None:
        """Advance the mean by a tick, and linearise the simulator there."""
        reached = self.simulator.fly(self.x + PROBES, [self.tick]).states[:, 0]
        above, below = reached[1 : STATE_SIZE + 1], reached[STATE_SIZE + 1 :]
        self.F = ((above - below) / (2 * STEPS[:, None])).T
        self.x = reached[0]

    def update_part(self, z: Floats, part: slice, R: Floats) -> None:
        """Take measured components of the state, with covariance R."""
        self.update(z, lambda _: WHOLE[part], lambda x: x[part], R=R)


def _cheapest(
    states: Floats, mask: Bools, simulator: Simulator, tick: float
) -> tuple[Floats, Floats]:
    """Return mean and covariance at the last of (12, 6) measurements, by the cheapest path."""
    now, cheapest = (np.zeros(STATE_SIZE), np.zeros((STATE_SIZE, STATE_SIZE))), np.inf
    placed = np.flatnonzero(mask[:, :3].all(axis=1)).tolist()
    costs = dict.fromkeys(placed[:1], 0)
    for start in placed:
        if costs.get(start, np.inf) >= cheapest:
            continue
        ball, outliers = _tracked(states[start:], mask[start:], simulator, tick)
        if costs[start] + len(outliers) < cheapest:
            now, cheapest = (ball.x, ball.P), costs[start] + len(outliers)
        for earlier, outlier in enumerate(outliers):
            cost = costs[start] + earlier + RESTART_PENALTY
            costs[start + outlier] = min(cost, costs.get(start + outlier, cost))
    return now


def _tracked(
    states: Floats, mask: Bools, simulator: Simulator, tick: float
) -> tuple[_BallFilter, list[int]]:
    """Filter measurements from the first; return the filter and which were outliers."""
    ball = _BallFilter(simulator, tick, *_first_guess(states, mask, tick))
    outliers = []
    for k, (measured, there) in enumerate(zip(states, mask, strict=True)):
        if k > 0:
            ball.predict()
        if there[:3].all():
            y = measured[:3] - ball.x[POSITION]
            S = ball.P[POSITION, POSITION] + NOISE_OF_POSITION
            if y @ np.linalg.solve(S, y) < OUTLIER_DISTANCE:
                ball.update_part(measured[:3], POSITION, NOISE_OF_POSITION)
            else:
                outliers.append(k)
        if there[3:].all():
            noise = SPIN_NOISE_SHARE * float(np.linalg.norm(measured[3:])) + SPIN_NOISE_FLOOR
            ball.update_part(measured[3:], SPIN, noise**2 * np.eye(3))
    return ball, outliers


def _first_guess(states: Floats, mask: Bools, tick: float) -> tuple[Floats, Floats]:
    """Return mean and covariance at the first measurement, whose position is known."""
    first = np.flatnonzero(mask[:, :3].all(axis=1))[:FIRST_SAMPLES]
    x = np.zeros(STATE_SIZE)
    x[POSITION] = states[0, :3]
    left, right = np.triu_indices(len(first), k=1)
    if len(left):
        spans = tick * (first[right] - first[left])
        slopes = (states[first[right], :3] - states[first[left], :3]) / spans[:, None]
        x[VELOCITY] = np.median(slopes, axis=0)
    labelled = np.flatnonzero(mask[:, 3:].all(axis=1))
    spread = np.repeat([10 * POSITION_NOISE, VELOCITY_PRIOR, SPIN_PRIOR], 3)
    if len(labelled):
        x[SPIN] = states[labelled[0], 3:]
        spread[SPIN] = max(SPIN_PRIOR, float(np.linalg.norm(x[SPIN])))
    return x, np.diag(spread**2)
