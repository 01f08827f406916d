"""Forecast protocols: from what each control step's forecast is computed.

- ``exact``: the true future. Policies train on it.
- ``first_state``: a simulator flies the ball from its true launch, once for the whole flight, so
  errors grow along it. The paper's sim-to-sim protocol.
- ``re_anchored``: a simulator flies the ball from its true state at each control step.
- ``filtered_balls``: a filter forecasts from simulated measurements, as on a robot.

Control steps start at the launch, those of a filter with its first window. All return the
``forecasts`` of ``IncomingBalls``, (B, T, H, 9). Forecasts of measured balls are in
``rallygap.models.replay.replayed_balls``.
"""

import numpy as np

from rallygap.models.ball.simulator import Simulator
from rallygap.models.ball.state import STATE_SIZE
from rallygap.models.ball.types import Floats
from rallygap.models.policy.incoming_balls import (
    FIRST_WINDOW,
    PATH_STEP,
    IncomingBalls,
    control_times,
)
from rallygap.models.policy.measurements import measure
from rallygap.models.policy.settings import HorizonsMs, SensorNoise
from rallygap.models.predictors.ball_filter import filtered
from rallygap.models.predictors.propagation import propagated
from rallygap.models.predictors.protocol import HISTORY, TICK, History

NOISE = SensorNoise(position=0.003, spin=0.05)  # the paper's cameras


def exact(path: Floats, horizons: HorizonsMs, start: float = 0.0) -> Floats:
    """Return the true future of (B, N, 9) paths; control steps begin ``start`` s after launches."""
    return path[:, np.rint(_forecast_times(horizons, start) / PATH_STEP).astype(np.int64)]


def first_state(simulator: Simulator, launches: Floats, horizons: HorizonsMs) -> Floats:
    """Return the future as ``simulator`` flies the balls from their (B, 9) launches."""
    wanted = _forecast_times(horizons, 0.0)
    times, indices = np.unique(wanted.round(9), return_inverse=True)
    return simulator.fly(launches, times).states[:, indices.reshape(wanted.shape)]


def re_anchored(simulator: Simulator, path: Floats, horizons: HorizonsMs) -> Floats:
    """Return the future as ``simulator`` flies (B, N, 9) paths on from each control step."""
    now = path[:, np.rint(control_times(0.0) / PATH_STEP).astype(np.int64)]
    flown = simulator.fly(now.reshape(-1, STATE_SIZE), np.array(horizons) / 1000).states
    return flown.reshape(len(now), -1, len(horizons), STATE_SIZE)


def filtered_balls(
    simulator: Simulator,
    path: Floats,
    playable: Floats,
    horizons: HorizonsMs,
    random: np.random.Generator,
) -> IncomingBalls:
    """Return balls with the forecasts of a filter and their standard deviations.

    Control steps begin when the predictor has its first window of noisy measurements of the (B, N,
    9) paths. Forecasts of balls that are out of play are zero.
    """
    times = control_times(FIRST_WINDOW)
    in_play = times < playable[:, 1:]
    measured, mask = measure(path, np.full(len(path), np.inf), NOISE, random)
    # At each control step the last 12 measurements, ball by ball.
    rows = np.rint(times / TICK).astype(np.int64)[:, None] + np.arange(1 - HISTORY, 1)
    now = filtered(History(measured[:, rows][in_play], mask[:, rows][in_play]), simulator)
    ahead = np.array(horizons) / 1000
    states, covariances = propagated(simulator, now.states, now.covariances, ahead, components=3)
    forecasts = np.zeros((*in_play.shape, len(horizons), STATE_SIZE))
    spreads = np.zeros((*in_play.shape, len(horizons), 3))
    forecasts[in_play] = states
    spreads[in_play] = np.sqrt(np.diagonal(covariances, axis1=-2, axis2=-1))
    return IncomingBalls(path, playable, FIRST_WINDOW, forecasts, spreads)


def forecast_error(incoming: IncomingBalls, horizons: HorizonsMs) -> float:
    """Return the mean distance between forecast and true position, m.

    At the middle horizon, over all control steps before a ball is out of play.
    """
    true = exact(incoming.path, horizons, incoming.start)
    errors = np.linalg.norm((incoming.forecasts - true)[:, :, 1, :3], axis=2)
    in_play = control_times(incoming.start) < incoming.playable[:, 1:]
    return float(errors[in_play].mean())


def _forecast_times(horizons: HorizonsMs, start: float) -> Floats:
    """Return the (T, H) times that are forecast, s from the launch."""
    return control_times(start)[:, None] + np.array(horizons) / 1000
