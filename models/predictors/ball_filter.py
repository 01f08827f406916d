"""An extended Kalman filter of ball states, compiled, for any number of balls at once.

State: position, velocity, spin. The motion model is the simulator, contacts included, linearised by
central differences. Every ball starts at its first measurement; a ball without a spin label starts
with a wide prior on spin, so that only the curvature of the path informs it.

An outlier among the first measurements, or a wrongly simulated contact, can make the filter reject
all later measurements; restarting it at one of them recovers the ball, but restarting at a true
outlier loses it. So every path through the history costs its number of outliers plus
``RESTART_PENALTY`` a restart, and the cheapest path wins.
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from rallygap.models.ball.compose import compiled, inlined
from rallygap.models.ball.rollout import fly
from rallygap.models.ball.simulator import Simulator
from rallygap.models.ball.state import STATE_SIZE
from rallygap.models.predictors.protocol import TICK, Bools, Floats, History

# Measurement noise: 3 mm and 5 % of the spin in the paper; up to 4.4 mm in real data sets.
POSITION_NOISE = 0.004  # m
SPIN_NOISE_SHARE = 0.05  # of the spin
SPIN_NOISE_FLOOR = 5.0  # rad/s

# Prior before the first measurement.
FIRST_SAMPLES = 4  # samples whose slopes give the initial velocity
VELOCITY_PRIOR = 5.0  # m/s; wide enough for a bounce among these samples
SPIN_PRIOR = 150.0  # rad/s, where the spin is not labelled

# Process noise: errors of the simulator in one tick of 5 ms.
NOISE_TICK = 0.005  # s
ACCELERATION_NOISE = 2.0  # m/s^2
SPIN_DRIFT = 1.0  # rad/s

# A position whose squared Mahalanobis distance exceeds this is an outlier (3 degrees of freedom,
# one in 10^5).
OUTLIER_DISTANCE = 25.9
# A restart of the filter counts as much as this many outliers. One true outlier makes up to three:
# lost samples on either side are interpolated towards it.
RESTART_PENALTY = 3

SIZE = STATE_SIZE
# Steps of central differences: m, m/s, rad/s.
STEPS = np.repeat([1e-5, 1e-3, 1e-1], 3)
PROBES = np.vstack([np.zeros(SIZE), np.diag(STEPS), -np.diag(STEPS)])


@dataclass(frozen=True)
class Filtered:
    """Filtered states of B balls at the last tick.

    Attributes:
        states: (B, 9) means: position (m), velocity (m/s), spin (rad/s).
        covariances: (B, 9, 9) of these.
    """

    states: Floats
    covariances: Floats


@dataclass(frozen=True)
class Expected:
    """What is known of balls before they are measured.

    Attributes:
        noise: m, standard deviation of a measured coordinate.
        spin: rad/s, mean about three axes: along the horizontal course, to its left, and up.
        spin_spread: rad/s, standard deviations about these. A label replaces mean and spread.
    """

    noise: float = POSITION_NOISE
    spin: tuple[float, float, float] = (0.0, 0.0, 0.0)
    spin_spread: tuple[float, float, float] = (SPIN_PRIOR, SPIN_PRIOR, SPIN_PRIOR)


ANY_BALL = Expected()


def filtered(
    history: History, simulator: Simulator, expected: Expected = ANY_BALL, tick: float = TICK
) -> Filtered:
    """Filter balls; one without any measured position is at the table's centre, at rest.

    Args:
        history: of B balls.
        simulator: the motion model.
        expected: of the balls.
        tick: s, between two states of the history.
    """
    placed: Bools = np.all(history.mask[:, :, :3], axis=2)
    labelled: Bools = np.all(history.mask[:, :, 3:], axis=2)
    states = np.ascontiguousarray(history.states)
    prior = np.array([expected.noise, *expected.spin, *expected.spin_spread])
    return Filtered(*_filter_all(states, placed, labelled, simulator.vector, prior, tick))


@compiled
def _filter_all(
    measured: Floats, placed: Bools, labelled: Bools, p: Floats, prior: Floats, tick: float
) -> tuple[Floats, Floats]:
    """Filter (B, N, 6) measured positions and spins, of which some are there."""
    states = np.zeros((len(measured), SIZE))
    covariances = np.zeros((len(measured), SIZE, SIZE))
    for b in range(len(measured)):
        states[b], covariances[b] = _filter_one(measured[b], placed[b], labelled[b], p, prior, tick)
    return states, covariances


@inlined
def _filter_one(
    measured: Floats, placed: Bools, labelled: Bools, p: Floats, prior: Floats, tick: float
) -> tuple[Floats, Floats]:
    """Return the last state and its covariance, by the cheapest path through the history."""
    state, covariance, cheapest = np.zeros(SIZE), np.zeros((SIZE, SIZE)), np.inf
    costs = np.full(len(measured), np.inf)  # by start: the cost up to it
    if placed.any():
        costs[np.argmax(placed)] = 0.0
    for start in range(len(measured)):
        if costs[start] >= cheapest:
            continue
        reached, spread, outliers = _track(
            measured[start:], placed[start:], labelled[start:], p, prior, tick
        )
        if costs[start] + outliers.sum() < cheapest:
            state, covariance, cheapest = reached, spread, costs[start] + outliers.sum()
        cost = costs[start] + RESTART_PENALTY
        for k in np.flatnonzero(outliers):
            costs[start + k] = min(costs[start + k], cost)
            cost += 1.0
    return state, covariance


@inlined
def _track(
    measured: Floats, placed: Bools, labelled: Bools, p: Floats, prior: Floats, tick: float
) -> tuple[Floats, Floats, Bools]:
    """Filter measurements from the first; return the last state and which were outliers."""
    x, P = _first_guess(measured, placed, labelled, prior, tick)
    outliers = np.zeros(len(measured), dtype=np.bool_)
    for k in range(len(measured)):
        if k > 0:
            x, P = advanced(x, P, tick, p)
        if placed[k]:
            R = prior[0] ** 2 * np.eye(3)
            outliers[k] = distance(x, P, measured[k, :3], R) >= OUTLIER_DISTANCE
            if not outliers[k]:
                x, P = updated(x, P, measured[k, :3], 0, R)
        if labelled[k]:
            x, P = updated(x, P, measured[k, 3:], 6, label_noise(measured[k, 3:]))
    return x, P, outliers


@compiled
def advanced(x: Floats, P: Floats, dt: float, p: Floats) -> tuple[Floats, Floats]:
    """Return (9,) mean and (9, 9) covariance ``dt`` s later, at most a tick; p of the simulator."""
    reached = fly(x + PROBES, np.full((len(PROBES), 1), dt), p)[0]
    F = np.empty((SIZE, SIZE))
    for j in range(SIZE):
        F[:, j] = (reached[1 + j, 0] - reached[1 + SIZE + j, 0]) / (2 * STEPS[j])
    return reached[0, 0].copy(), F @ P @ F.T + _process_noise(dt)


@compiled
def _process_noise(dt: float) -> Floats:
    """Return the (9, 9) covariance of the simulator's errors: a white acceleration and drift."""
    Q = np.zeros((SIZE, SIZE))
    density = ACCELERATION_NOISE**2 * NOISE_TICK / dt  # the same noise a second at every rate
    for i in range(3):
        Q[i, i] = density * dt**4 / 4
        Q[i, i + 3] = Q[i + 3, i] = density * dt**3 / 2
        Q[i + 3, i + 3] = density * dt**2
        Q[i + 6, i + 6] = SPIN_DRIFT**2 * dt / NOISE_TICK
    return Q


@compiled
def distance(x: Floats, P: Floats, position: Floats, R: Floats) -> float:
    """Return the squared Mahalanobis distance of a measured position; R is its covariance."""
    y = position - x[:3]
    return float(y @ _inverse(P[:3, :3] + R) @ y)


@compiled
def updated(x: Floats, P: Floats, measured: Floats, first: int, R: Floats) -> tuple[Floats, Floats]:
    """Return (9,) mean and (9, 9) covariance after three components from ``first`` were measured.

    ``first`` is 0 for a position and 6 for a spin, R the (3, 3) covariance of the measurement. The
    result is in Joseph's form, which stays positive definite.
    """
    end = first + 3
    K = np.ascontiguousarray(P[:, first:end]) @ _inverse(P[first:end, first:end] + R)
    left = np.eye(SIZE)
    left[:, first:end] -= K
    return x + K @ (measured - x[first:end]), left @ P @ left.T + K @ R @ K.T


@compiled
def label_noise(spin: Floats) -> Floats:
    """Return the (3, 3) covariance of a spin label."""
    error = SPIN_NOISE_SHARE * np.sqrt((spin**2).sum()) + SPIN_NOISE_FLOOR
    return error**2 * np.eye(3)


@compiled
def _inverse(a: Floats) -> Floats:
    """Return the inverse of a (3, 3) symmetric matrix."""
    cofactors = np.empty((3, 3))
    for i in range(3):
        j, k = (i + 1) % 3, (i + 2) % 3
        for m in range(3):
            n, o = (m + 1) % 3, (m + 2) % 3
            cofactors[m, i] = a[j, n] * a[k, o] - a[j, o] * a[k, n]
    return cofactors / (a[0] * cofactors[:, 0]).sum()


@compiled
def _first_guess(
    measured: Floats, placed: Bools, labelled: Bools, prior: Floats, tick: float
) -> tuple[Floats, Floats]:
    """Return mean and covariance at the first measurement, whose position is known."""
    x, P = np.zeros(SIZE), np.zeros((SIZE, SIZE))
    x[:3] = measured[0, :3]
    x[3:6] = _median_slope(measured, np.flatnonzero(placed)[:FIRST_SAMPLES], tick)
    course = course_axes(x[3:6])
    x[6:] = course @ prior[1:4]
    P[6:, 6:] = (course * prior[4:] ** 2) @ course.T
    if labelled.any():
        x[6:] = measured[np.argmax(labelled), 3:]
        P[6:, 6:] = max(SPIN_PRIOR, np.sqrt((x[6:] ** 2).sum())) ** 2 * np.eye(3)
    for i in range(3):
        P[i, i] = (10 * prior[0]) ** 2
        P[i + 3, i + 3] = VELOCITY_PRIOR**2
    return x, P


@compiled
def course_axes(velocity: Floats) -> Floats:
    """Return the (3, 3) axes, in columns, along a horizontal course, to its left, and up."""
    axes, speed = np.eye(3), np.sqrt(velocity[0] ** 2 + velocity[1] ** 2)
    if speed > 0.0:
        x, y = velocity[0] / speed, velocity[1] / speed
        axes[:2, 0] = x, y
        axes[:2, 1] = -y, x
    return axes


@compiled
def _median_slope(measured: Floats, rows: NDArray[np.signedinteger], tick: float) -> Floats:
    """Return the median slope over all pairs of rows, robust to one outlier; zero for one row."""
    count = len(rows)
    slopes = np.empty((count * (count - 1) // 2, 3))
    pair = 0
    for i in range(count):
        for j in range(i + 1, count):
            span = tick * (rows[j] - rows[i])
            slopes[pair] = (measured[rows[j], :3] - measured[rows[i], :3]) / span
            pair += 1
    velocity = np.zeros(3)
    if pair > 0:
        for i in range(3):
            velocity[i] = np.median(slopes[:, i])
    return velocity
