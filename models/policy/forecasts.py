"""Forecast protocols: what a policy is told of the ball's future at each control tick.

- `exact`: the truth. Policies train on it.
- `first_state`: a simulator flies the ball from its true launch; the whole flight is forecast at
  once, and errors grow along it. The sim-to-sim protocol of the paper.
- `re_anchored`: a simulator flies the ball from its true state at each tick.
- `first_window`: a filter takes in the first 12 measurements, and its simulator flies the ball from
  there; the whole flight is forecast at once.
- `every_tick`: a predictor sees the last 12 measurements at each tick. What a robot does.

The first three know the ball from its launch on: ticks start at 0. The others must have seen it:
ticks start at ``FIRST_WINDOW``. All return the ``forecasts`` of an ``Incoming``: (B, T, H, 9)
states at the T ticks plus the H horizons.
"""

import numpy as np
from numpy.typing import NDArray

from models.ball.simulator import Simulator
from models.ball.state import STATE_SIZE
from models.policy.incoming import FIRST_WINDOW, PATH_STEP, tick_times
from models.policy.measurements import Measurements, first_sight, sightings
from models.policy.settings import HorizonsMs
from models.predictors.physics import PhysicsPredictor
from models.predictors.protocol import FUTURE, TICK, History, Predictor

Floats = NDArray[np.float64]

WINDOWS_AT_ONCE = 2048  # that a predictor is given, for the memory's sake


def exact(path: Floats, horizons: HorizonsMs, start: float = 0.0) -> Floats:
    """Return the true future.

    Args:
        path: (B, N, 9) true states as in ``Incoming``.
        horizons: ms.
        start: s from the launch of the first tick.
    """
    return path[:, np.rint(_instants(horizons, start) / PATH_STEP).astype(np.int64)]


def first_state(simulator: Simulator, launches: Floats, horizons: HorizonsMs) -> Floats:
    """Return the future as ``simulator`` flies the ball from its (B, 9) launch."""
    return _flown(simulator, launches, _instants(horizons, 0.0))


def re_anchored(simulator: Simulator, path: Floats, horizons: HorizonsMs) -> Floats:
    """Return the future as ``simulator`` flies the ball from its true state at each tick.

    Args:
        simulator: that forecasts.
        path: (B, N, 9) true states as in ``Incoming``.
        horizons: ms.
    """
    now = path[:, np.rint(tick_times(0.0) / PATH_STEP).astype(np.int64)]
    flown = simulator.fly(now.reshape(-1, STATE_SIZE), np.array(horizons) / 1000).states
    ahead: Floats = flown.reshape(len(now), -1, len(horizons), STATE_SIZE)
    return ahead


def first_window(simulator: Simulator, measurements: Measurements, horizons: HorizonsMs) -> Floats:
    """Return the future as ``simulator`` flies the ball on from its filtered first window.

    The filter's motion is the simulator's, too.
    """
    soon = PhysicsPredictor(simulator).predict(first_sight(measurements)).states[:, 0]
    return _flown(simulator, soon, _instants(horizons, FIRST_WINDOW) - FIRST_WINDOW - TICK)


def every_tick(predictor: Predictor, measurements: Measurements, horizons: HorizonsMs) -> Floats:
    """Return the future as ``predictor`` tells it from the last 12 measurements at each tick.

    Once the cameras have lost the ball, its last complete window is asked for horizons that lie
    that much further ahead; beyond the end of the forecast the ball stays where that ends.
    """
    seen = sightings(measurements)
    forecast = _predicted(predictor, seen.history)
    ahead = np.rint(np.array(horizons) / (1000 * TICK)).astype(np.int64) - 1
    state = np.minimum(seen.age[..., None] + ahead, FUTURE - 1)
    told: Floats = forecast[seen.latest[..., None], state]
    return told


def _instants(horizons: HorizonsMs, start: float) -> Floats:
    """Return the (T, H) instants that are forecast, s from the launch."""
    instants: Floats = tick_times(start)[:, None] + np.array(horizons) / 1000
    return instants


def _flown(simulator: Simulator, states: Floats, instants: Floats) -> Floats:
    """Return (B, T, H, 9) states at (T, H) instants, s from the given (B, 9) states."""
    times, places = np.unique(instants.round(9), return_inverse=True)
    return simulator.fly(states, times).states[:, places.reshape(instants.shape)]


def _predicted(predictor: Predictor, history: History) -> Floats:
    """Return the (S, 60, 9) forecasts from S histories."""
    starts = range(0, len(history), WINDOWS_AT_ONCE)
    parts = [history[start : start + WINDOWS_AT_ONCE] for start in starts]
    return np.concatenate([predictor.predict(part).states for part in parts])
