"""Forecasts farther ahead than the 300 ms of a predictor.

A simulator flies on. A learned predictor forecasts from what it has forecast: the last twelve
states of a forecast are the history of the next one, so its errors accumulate.
"""

import math

import numpy as np
from numpy.typing import NDArray

from rallygap.models.predictors.physics import PhysicsPredictor
from rallygap.models.predictors.protocol import FUTURE, HISTORY, TICK, Floats, History, Predictor

PLACED = [0, 1, 2, 6, 7, 8]  # columns of a state that a history has


def forecast_at(predictor: Predictor, history: History, ahead: Floats) -> Floats:
    """Return the (B, T, 9) states of balls at (B, T) s after their histories, not falling."""
    if isinstance(predictor, PhysicsPredictor):
        return predictor.states_at(history, ahead)
    states = rolled_out(predictor, history, float(ahead.max()))
    return between_ticks(states, np.arange(len(states))[:, None], ahead)


def rolled_out(predictor: Predictor, history: History, until: float) -> Floats:
    """Return (B, N, 9) states a tick apart, from 5 ms to at least ``until``, in s."""
    spans = max(math.ceil(until / TICK / FUTURE - 1e-9), 1)
    parts = [predictor.predict(history).states]
    mask = np.ones((len(history), HISTORY, 6), dtype=np.bool_)
    mask[..., 3:] = history.spin_measured[:, None, None]
    while len(parts) < spans:
        recent = np.where(mask, parts[-1][:, -HISTORY:, PLACED], 0.0)
        parts.append(predictor.predict(History(recent, mask)).states)
    return np.concatenate(parts, axis=1)


def between_ticks(forecasts: Floats, rows: NDArray[np.int64], ahead: Floats) -> Floats:
    """Return (..., C) states between those of forecasts; beyond their ends, the nearest one.

    Args:
        forecasts: (S, N, C) a tick apart, from 5 ms on.
        rows: (...) which of these.
        ahead: (...) s.
    """
    last = forecasts.shape[1] - 1
    place = np.clip((ahead / TICK - 1).round(6), 0, last)
    before = place.astype(np.int64)
    after, share = np.minimum(before + 1, last), (place - before)[..., None]
    return (1 - share) * forecasts[rows, before] + share * forecasts[rows, after]
