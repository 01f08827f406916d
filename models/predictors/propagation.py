"""What a simulator makes of an uncertain state: mean and covariance at coming times."""

import numpy as np

from models.ball.simulator import Simulator
from models.ball.state import STATE_SIZE
from models.ball.types import Floats
from models.predictors.ball_filter import ACCELERATION_NOISE, NOISE_TICK, SPIN_DRIFT, STEPS

PROBES = np.vstack([np.zeros(STATE_SIZE), np.diag(STEPS), -np.diag(STEPS)])


def propagated(
    simulator: Simulator, states: Floats, covariances: Floats, ahead: Floats
) -> tuple[Floats, Floats]:
    """Return means and covariances of balls at coming times.

    The covariance is linear in that of the state, contacts included, with the process noise of the
    filter (ball_filter.py) as it grows in free flight.

    Args:
        simulator: of the balls.
        states: (B, 9) means now.
        covariances: (B, 9, 9) of these.
        ahead: (T,) s from now, not falling.

    Returns:
        (B, T, 9) means and (B, T, 9, 9) covariances.
    """
    count = len(states)
    probes = (states[:, None] + PROBES).reshape(-1, STATE_SIZE)
    flown = simulator.fly(probes, ahead).states
    flown = flown.reshape(count, len(PROBES), len(ahead), STATE_SIZE)
    above, below = flown[:, 1 : STATE_SIZE + 1], flown[:, STATE_SIZE + 1 :]
    slopes = np.moveaxis((above - below) / (2 * STEPS[:, None, None]), 1, 3)
    spread = slopes @ covariances[:, None] @ np.swapaxes(slopes, 2, 3)
    powers = np.maximum(ahead, 0.0)[:, None, None, None] ** (1, 2, 3)
    return flown[:, 0], spread + (powers * GROWTH).sum(axis=3)


def _growth() -> Floats:
    """Return (9, 9, 3) what process noise adds in free flight by time, its square and its cube."""
    density = ACCELERATION_NOISE**2 * NOISE_TICK
    growth = np.zeros((STATE_SIZE, STATE_SIZE, 3))
    for i in range(3):
        growth[i, i, 2] = density / 3
        growth[i, i + 3, 1] = growth[i + 3, i, 1] = density / 2
        growth[i + 3, i + 3, 0] = density
        growth[i + 6, i + 6, 0] = SPIN_DRIFT**2 / NOISE_TICK
    return growth


GROWTH = _growth()
