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
    return flown[:, 0], spread + _added(np.maximum(ahead, 0.0))


def _added(ahead: Floats) -> Floats:
    """Return (T, 9, 9) what process noise adds in free flight."""
    density = ACCELERATION_NOISE**2 * NOISE_TICK
    added = np.zeros((len(ahead), STATE_SIZE, STATE_SIZE))
    for i in range(3):
        added[:, i, i] = density * ahead**3 / 3
        added[:, i, i + 3] = added[:, i + 3, i] = density * ahead**2 / 2
        added[:, i + 3, i + 3] = density * ahead
        added[:, i + 6, i + 6] = SPIN_DRIFT**2 * ahead / NOISE_TICK
    return added
