"""Forecast protocols: what a policy is told of the ball's future at each control tick.

- `exact`: the truth. Policies train on it.
- `first_state`: a simulator flies the ball from its true launch; the whole flight is forecast at
  once, and errors grow along it. The sim-to-sim protocol of the paper.
- `re_anchored`: a simulator flies the ball from its true state at each tick.

Ticks start at the launch. All return the ``forecasts`` of an ``Incoming``: (B, T, H, 9) states at
the T ticks plus the H horizons. Measured balls are forecast from what was measured: `replay.py`.
"""

import numpy as np
from numpy.typing import NDArray

from models.ball.simulator import Simulator
from models.ball.state import STATE_SIZE
from models.policy.incoming_balls import PATH_STEP, tick_times
from models.policy.settings import HorizonsMs

Floats = NDArray[np.float64]


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


def _instants(horizons: HorizonsMs, start: float) -> Floats:
    """Return the (T, H) instants that are forecast, s from the launch."""
    instants: Floats = tick_times(start)[:, None] + np.array(horizons) / 1000
    return instants


def _flown(simulator: Simulator, states: Floats, instants: Floats) -> Floats:
    """Return (B, T, H, 9) states at (T, H) instants, s from the given (B, 9) states."""
    times, places = np.unique(instants.round(9), return_inverse=True)
    return simulator.fly(states, times).states[:, places.reshape(instants.shape)]
