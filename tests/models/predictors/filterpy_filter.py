"""The ball filter by filterpy, which the compiled one has to agree with."""

import numpy as np
from filterpy.common import Q_discrete_white_noise
from filterpy.kalman import ExtendedKalmanFilter
from scipy.linalg import block_diag

from rallygap.models.ball.state import POSITION, SPIN, STATE_SIZE, VELOCITY
from rallygap.models.predictors.ball_filter import (
    ACCELERATION_NOISE,
    FIRST_SAMPLES,
    OUTLIER_DISTANCE,
    POSITION_NOISE,
    RESTART_PENALTY,
    SPIN_DRIFT,
    SPIN_NOISE_FLOOR,
    SPIN_NOISE_SHARE,
    SPIN_PRIOR,
    STEPS,
    VELOCITY_PRIOR,
)
from rallygap.models.predictors.protocol import TICK

PROBES = np.vstack([np.zeros(STATE_SIZE), np.diag(STEPS), -np.diag(STEPS)])


class BallFilter(ExtendedKalmanFilter):
    """filterpy's filter with a simulator as its motion model, in the usual symbols."""

    def __init__(self, simulator, x, P):
        super().__init__(dim_x=STATE_SIZE, dim_z=3)
        self.simulator = simulator
        self.x, self.P = x, P
        q = Q_discrete_white_noise(2, TICK, ACCELERATION_NOISE**2, block_size=3, order_by_dim=False)
        self.Q = block_diag(q, SPIN_DRIFT**2 * np.eye(3))

    def predict_x(self, u=0):
        reached = self.simulator.fly(self.x + PROBES, [TICK]).states[:, 0]
        above, below = reached[1 : STATE_SIZE + 1], reached[STATE_SIZE + 1 :]
        self.F = ((above - below) / (2 * STEPS[:, None])).T
        self.x = reached[0]

    def update_position(self, position):
        R = POSITION_NOISE**2 * np.eye(3)
        y = position - self.x[POSITION]
        S = self.P[POSITION, POSITION] + R
        expected = bool(y @ np.linalg.solve(S, y) < OUTLIER_DISTANCE)
        if expected:
            self.update_part(position, POSITION, R)
        return expected

    def update_spin(self, spin):
        noise = SPIN_NOISE_SHARE * float(np.linalg.norm(spin)) + SPIN_NOISE_FLOOR
        self.update_part(spin, SPIN, noise**2 * np.eye(3))

    def update_part(self, z, part, R):
        H = np.eye(STATE_SIZE)[part]
        self.update(z, lambda _: H, lambda x: x[part], R=R)


def filtered_by_filterpy(states, mask, simulator):
    """Return mean and covariance at the last of (12, 6) measurements."""
    now, cheapest = (np.zeros(STATE_SIZE), np.zeros((STATE_SIZE, STATE_SIZE))), np.inf
    placed = np.flatnonzero(mask[:, :3].all(axis=1)).tolist()
    costs = dict.fromkeys(placed[:1], 0)
    for start in placed:
        if costs.get(start, np.inf) >= cheapest:
            continue
        ball, outliers = tracked(states, mask, start, simulator)
        if costs[start] + len(outliers) < cheapest:
            now, cheapest = (ball.x, ball.P), costs[start] + len(outliers)
        for earlier, outlier in enumerate(outliers):
            cost = costs[start] + earlier + RESTART_PENALTY
            costs[outlier] = min(cost, costs.get(outlier, cost))
    return now


def tracked(states, mask, start, simulator):
    ball = BallFilter(simulator, *first_guess(states[start:], mask[start:]))
    outliers = []
    for k in range(start, len(states)):
        if k > start:
            ball.predict()
        if mask[k, :3].all() and not ball.update_position(states[k, :3]):
            outliers.append(k)
        if mask[k, 3:].all():
            ball.update_spin(states[k, 3:])
    return ball, outliers


def first_guess(states, mask):
    first = np.flatnonzero(mask[:, :3].all(axis=1))[:FIRST_SAMPLES]
    x = np.zeros(STATE_SIZE)
    x[POSITION] = states[0, :3]
    left, right = np.triu_indices(len(first), k=1)
    if len(left):
        spans = TICK * (first[right] - first[left])
        slopes = (states[first[right], :3] - states[first[left], :3]) / spans[:, None]
        x[VELOCITY] = np.median(slopes, axis=0)
    labelled = np.flatnonzero(mask[:, 3:].all(axis=1))
    spread = np.repeat([10 * POSITION_NOISE, VELOCITY_PRIOR, SPIN_PRIOR], 3)
    if len(labelled):
        x[SPIN] = states[labelled[0], 3:]
        spread[SPIN] = max(SPIN_PRIOR, float(np.linalg.norm(x[SPIN])))
    return x, np.diag(spread**2)
