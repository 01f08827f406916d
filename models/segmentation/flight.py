"""Kalman filter and smoother of a ball between two contacts.

The state of each axis is position, velocity and the acceleration that gravity and nominal drag
leave unexplained (Magnus force, a wrong drag coefficient), driven by white jerk. Drag is a known
input at the filter's own velocity; its Jacobian is left out of the covariance, so that all three
axes share one 3 x 3 covariance.

Arrays are ``mean (3, 3)`` with rows position (m), velocity (m/s), acceleration (m/s^2) and one
column an axis, and ``covariance (3, 3)`` over the rows of any one axis. All functions work in
place: the partition calls them millions of times.
"""

import math
from pathlib import Path

import numpy as np

from rallygap.models.ball import state
from rallygap.models.ball.state import DRAG_FACTOR
from rallygap.models.ball.types import Bools, Floats
from rallygap.models.support.compilation import compiler

# The decorator of this package's compiled functions.
compiled = compiler([*sorted(Path(__file__).parent.glob("*.py")), Path(state.__file__)])

GRAVITY = 9.81  # m/s^2
DRAG = DRAG_FACTOR * 0.54  # 1/m, the literature's drag coefficient
# Prior of the velocity: strokes reach 35 m/s, most stay under 15.
SPEED_SPREAD = 15.0  # m/s
# The Magnus force of 300 rad/s at 10 m/s gives 3 to 10 m/s^2.
ACCELERATION_SPREAD = 8.0  # m/s^2
# The unexplained acceleration changes by 3 m/s^2 within half a second.
JERK_DENSITY = 18.0  # (m/s^2)^2/s


@compiled
def initialise(mean: Floats, covariance: Floats, position: Floats, noise: float) -> None:
    """Set ``mean`` and ``covariance`` from an arc's first sample and the prior.

    Args:
        mean: overwritten.
        covariance: overwritten.
        position: the sample (3,), m.
        noise: standard deviation of a sample in each axis, m.
    """
    mean[:] = 0.0
    mean[0] = position
    mean[2, 2] = -GRAVITY
    covariance[:] = 0.0
    covariance[0, 0] = noise**2
    covariance[1, 1] = SPEED_SPREAD**2
    covariance[2, 2] = ACCELERATION_SPREAD**2


@compiled
def predict_mean(mean: Floats, dt: float) -> None:
    """Predict the mean ``dt`` seconds later, or earlier where ``dt`` is negative."""
    brake = DRAG * math.sqrt(mean[1, 0] ** 2 + mean[1, 1] ** 2 + mean[1, 2] ** 2)
    for axis in range(3):
        acceleration = mean[2, axis] - brake * mean[1, axis]
        mean[0, axis] += dt * mean[1, axis] + 0.5 * dt * dt * acceleration
        mean[1, axis] += dt * acceleration


@compiled
def transition(dt: float) -> Floats:
    """Return the transition matrix (3, 3) of one axis over ``dt`` seconds."""
    return np.array([[1.0, dt, 0.5 * dt * dt], [0.0, 1.0, dt], [0.0, 0.0, 1.0]])


@compiled
def predict_covariance(covariance: Floats, dt: float) -> None:
    """Predict the covariance ``dt`` seconds later, with white jerk as process noise."""
    # F P F^T with F = [[1, dt, dt^2/2], [0, 1, dt], [0, 0, 1]]: rows first, then columns.
    for k in range(3):
        covariance[0, k] += dt * covariance[1, k] + 0.5 * dt * dt * covariance[2, k]
        covariance[1, k] += dt * covariance[2, k]
    for k in range(3):
        covariance[k, 0] += dt * covariance[k, 1] + 0.5 * dt * dt * covariance[k, 2]
        covariance[k, 1] += dt * covariance[k, 2]
    covariance[0, 0] += JERK_DENSITY * dt**5 / 20
    covariance[1, 1] += JERK_DENSITY * dt**3 / 3
    covariance[2, 2] += JERK_DENSITY * dt
    for row, column, growth in ((0, 1, dt**4 / 8), (0, 2, dt**3 / 6), (1, 2, dt**2 / 2)):
        covariance[row, column] += JERK_DENSITY * growth
        covariance[column, row] = covariance[row, column]


@compiled
def negative_log_likelihood(
    mean: Floats, covariance: Floats, position: Floats, noise: float
) -> float:
    """Return a sample's negative log-likelihood (nats), relative to a perfectly predicted one."""
    variance = covariance[0, 0] + noise**2
    squared = 0.0
    for axis in range(3):
        squared += (position[axis] - mean[0, axis]) ** 2
    return float(0.5 * squared / variance + 1.5 * math.log(variance / noise**2))


@compiled
def update(mean: Floats, covariance: Floats, position: Floats, noise: float) -> None:
    """Update ``mean`` and ``covariance`` with a sample."""
    p, pv, pa = covariance[0]
    variance = p + noise**2
    # Last row first: every row needs the innovation of the predicted position.
    for row in range(2, -1, -1):
        gain = covariance[row, 0] / variance
        for axis in range(3):
            mean[row, axis] += gain * (position[axis] - mean[0, axis])
        covariance[row, 0] -= gain * p
        covariance[row, 1] -= gain * pv
        covariance[row, 2] -= gain * pa


@compiled
def smooth(t: Floats, x: Floats, used: Bools, noise: float) -> Floats:
    """Return the smoothed means (Rauch, Tung and Striebel) at all samples, given the used ones.

    Args:
        t: increasing times (n,), s.
        x: positions (n, 3), m.
        used: whether a sample (n,) is used; the first one must be.
        noise: standard deviation of a sample in each axis, m.

    Returns:
        Means (n, 3, 3): rows position, velocity, unexplained acceleration.
    """
    n = len(t)
    means, covariances = np.empty((n, 3, 3)), np.empty((n, 3, 3))
    predicted, predicted_covariances = np.empty((n, 3, 3)), np.empty((n, 3, 3))
    initialise(means[0], covariances[0], x[0], noise)
    for k in range(1, n):
        predicted[k], predicted_covariances[k] = means[k - 1], covariances[k - 1]
        predict_mean(predicted[k], t[k] - t[k - 1])
        predict_covariance(predicted_covariances[k], t[k] - t[k - 1])
        means[k], covariances[k] = predicted[k], predicted_covariances[k]
        if used[k]:
            update(means[k], covariances[k], x[k], noise)
    for k in range(n - 2, -1, -1):
        forward = transition(t[k + 1] - t[k])
        gain = np.linalg.solve(predicted_covariances[k + 1], forward @ covariances[k]).T
        means[k] += gain @ (means[k + 1] - predicted[k + 1])
    return means
