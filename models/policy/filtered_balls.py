"""Incoming balls whose forecasts a filter makes of simulated measurements, as on a robot."""

import numpy as np

from rallygap.models.ball.simulator import Simulator
from rallygap.models.ball.state import STATE_SIZE
from rallygap.models.ball.types import Bools, Floats
from rallygap.models.policy.incoming_balls import FIRST_WINDOW, IncomingBalls, control_times
from rallygap.models.policy.measurements import Measurements, measure
from rallygap.models.policy.settings import HorizonsMs, SensorNoise
from rallygap.models.predictors.ball_filter import filtered
from rallygap.models.predictors.propagation import propagated
from rallygap.models.predictors.protocol import HISTORY, TICK, History

NOISE = SensorNoise(position=0.003, spin=0.05)  # the paper's cameras


def filtered_balls(
    simulator: Simulator,
    path: Floats,
    playable: Floats,
    horizons: HorizonsMs,
    random: np.random.Generator,
) -> IncomingBalls:
    """Return balls with the forecasts of a filter and their standard deviations.

    Control steps begin when the predictor has its first window. Forecasts of balls that are out of
    play are zero.

    Args:
        simulator: that forecasts.
        path: (B, N, 9) true states as in ``IncomingBalls``.
        playable: (B, 2) s as in ``IncomingBalls``.
        horizons: ms.
        random: of the measurements' noise.
    """
    times = control_times(FIRST_WINDOW)
    in_play = times < playable[:, 1:]
    history = _histories(measure(path, np.full(len(path), np.inf), NOISE, random), times, in_play)
    now = filtered(history, simulator)
    ahead = np.array(horizons) / 1000
    states, covariances = propagated(simulator, now.states, now.covariances, ahead, components=3)
    forecasts = np.zeros((*in_play.shape, len(horizons), STATE_SIZE))
    spreads = np.zeros((*in_play.shape, len(horizons), 3))
    forecasts[in_play] = states
    variances = np.diagonal(covariances, axis1=-2, axis2=-1)
    spreads[in_play] = np.sqrt(variances)
    return IncomingBalls(path, playable, FIRST_WINDOW, forecasts, spreads)


def _histories(measured: Measurements, times: Floats, in_play: Bools) -> History:
    """Return the histories of the balls in play at (T,) control steps, ball by ball."""
    last = np.rint(times / TICK).astype(np.int64)[:, None]
    rows = last + np.arange(1 - HISTORY, 1)
    return History(measured.states[:, rows][in_play], measured.mask[:, rows][in_play])
