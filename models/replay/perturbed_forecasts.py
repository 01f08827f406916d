"""Tolerance: forecasts that are wrong on purpose, to see what a policy makes of them."""

from collections.abc import Callable, Mapping
from types import MappingProxyType

import numpy as np
from numpy.typing import NDArray

from models.ball.state import POSITION, SPIN

Floats = NDArray[np.float64]


def biased(forecasts: Floats, size: float, random: np.random.Generator) -> Floats:
    """Return forecasts that are off by ``size`` m, in one direction for each ball.

    Args:
        forecasts: (B, T, H, 9) as in ``Incoming``.
        size: of the error.
        random: where the directions come from, all equally likely.
    """
    drawn = random.standard_normal((len(forecasts), 1, 1, 3))
    return _moved(forecasts, size * drawn / np.linalg.norm(drawn, axis=-1, keepdims=True))


def noisy(forecasts: Floats, size: float, random: np.random.Generator) -> Floats:
    """Return forecasts that are off anew at each tick, by ``size`` m in the root mean square.

    The states of one tick are off alike, as those that a predictor sees in one window.
    """
    drawn = random.standard_normal((*forecasts.shape[:2], 1, 3))
    return _moved(forecasts, size / np.sqrt(3) * drawn)


def spinless(forecasts: Floats, size: float, random: np.random.Generator) -> Floats:
    """Return forecasts that say of every ball that it does not spin; there is one size of that."""
    changed = forecasts.copy()
    changed[..., SPIN] = 0.0
    return changed


ERRORS: Mapping[str, Callable[[Floats, float, np.random.Generator], Floats]] = MappingProxyType(
    {"bias": biased, "noise": noisy, "no_spin": spinless}
)


def _moved(forecasts: Floats, offset: Floats) -> Floats:
    changed = forecasts.copy()
    changed[..., POSITION] += offset
    return changed
