"""Forecasts with deliberate errors, to measure which errors a policy tolerates."""

from collections.abc import Callable, Mapping
from types import MappingProxyType

import numpy as np

from rallygap.models.ball.state import POSITION, SPIN
from rallygap.models.ball.types import Floats


def biased(forecasts: Floats, size: float, random: np.random.Generator) -> Floats:
    """Return forecasts biased by ``size`` m, in one random direction per ball.

    Args:
        forecasts: (B, T, H, 9) as in ``IncomingBalls``.
        size: of the error.
        random: of the directions, uniform on the sphere.
    """
    drawn = random.standard_normal((len(forecasts), 1, 1, 3))
    return _shifted(forecasts, size * drawn / np.linalg.norm(drawn, axis=-1, keepdims=True))


def noisy(forecasts: Floats, size: float, random: np.random.Generator) -> Floats:
    """Return forecasts with an independent error per control step, ``size`` m root mean square.

    All horizons of one step share the error, as they share one measurement window.
    """
    drawn = random.standard_normal((*forecasts.shape[:2], 1, 3))
    return _shifted(forecasts, size / np.sqrt(3) * drawn)


def spinless(forecasts: Floats, size: float, random: np.random.Generator) -> Floats:
    """Return forecasts with zero spin; ``size`` has no effect."""
    changed = forecasts.copy()
    changed[..., SPIN] = 0.0
    return changed


ERRORS: Mapping[str, Callable[[Floats, float, np.random.Generator], Floats]] = MappingProxyType(
    {"bias": biased, "noise": noisy, "no_spin": spinless}
)


def _shifted(forecasts: Floats, offset: Floats) -> Floats:
    changed = forecasts.copy()
    changed[..., POSITION] += offset
    return changed
