"""What a simulator makes of an uncertain state: mean and covariance at coming times."""

import numpy as np

from rallygap.models.ball.compose import compiled
from rallygap.models.ball.simulator import Simulator
from rallygap.models.ball.state import STATE_SIZE
from rallygap.models.ball.types import Floats
from rallygap.models.predictors.ball_filter import (
    ACCELERATION_NOISE,
    NOISE_TICK,
    PROBES,
    SPIN_DRIFT,
    STEPS,
)


def propagated(
    simulator: Simulator,
    states: Floats,
    covariances: Floats,
    ahead: Floats,
    components: int = STATE_SIZE,
) -> tuple[Floats, Floats]:
    """Return (B, T, 9) means and (B, T, C, C) covariances of balls at coming times.

    The covariance is linear in that of the state, contacts included, with the process noise of the
    filter (ball_filter.py) as it grows in free flight.

    Args:
        simulator: of the balls.
        states: (B, 9) means now.
        covariances: (B, 9, 9) of these.
        ahead: (T,) s from now, not falling.
        components: C, the first ones of a state, whose covariances are wanted.
    """
    count = len(states)
    probes = (states[:, None] + PROBES).reshape(-1, STATE_SIZE)
    flown = simulator.fly(probes, ahead).states
    flown = flown.reshape(count, len(PROBES), len(ahead), STATE_SIZE)
    growth = GROWTH[:, :components, :components]
    return flown[:, 0], _covariances(flown, covariances, ahead, growth)


@compiled
def _covariances(flown: Floats, now: Floats, ahead: Floats, growth: Floats) -> Floats:
    """Return (B, T, C, C) covariances of (B, 19, T, 9) probes, from (B, 9, 9) now."""
    balls, _, times, size = flown.shape
    count = growth.shape[1]
    covariances = np.empty((balls, times, count, count))
    slopes, half = np.empty((count, size)), np.empty((count, size))
    for b in range(balls):
        for t in range(times):
            for j in range(size):
                for i in range(count):
                    change = flown[b, 1 + j, t, i] - flown[b, 1 + size + j, t, i]
                    slopes[i, j] = change / (2 * STEPS[j])
            span = max(ahead[t], 0.0)
            _multiply(slopes, now[b], half)
            _multiply(half, slopes.T, covariances[b, t])
            for k in range(3):
                covariances[b, t] += growth[k] * span ** (k + 1)
    return covariances


@compiled
def _multiply(left: Floats, right: Floats, product: Floats) -> None:
    """Write the product of two small matrices; a library would take longer to be called."""
    for i in range(left.shape[0]):
        for j in range(right.shape[1]):
            total = 0.0
            for k in range(left.shape[1]):
                total += left[i, k] * right[k, j]
            product[i, j] = total


def _growth() -> Floats:
    """Return (3, 9, 9) what process noise adds in free flight by time, its square and its cube."""
    density = ACCELERATION_NOISE**2 * NOISE_TICK
    growth = np.zeros((3, STATE_SIZE, STATE_SIZE))
    for i in range(3):
        growth[2, i, i] = density / 3
        growth[1, i, i + 3] = growth[1, i + 3, i] = density / 2
        growth[0, i + 3, i + 3] = density
        growth[0, i + 6, i + 6] = SPIN_DRIFT**2 / NOISE_TICK
    return growth


GROWTH = _growth()
