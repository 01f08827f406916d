"""Flights of the ``Ball`` of a ``ball_effects.py``, in whatever engine it is."""

from typing import Any

import numpy as np

from rallygap.models.ball.types import Floats


def flown(ball: Any, state: Floats, times: Floats, step: float) -> list[tuple[float, ...]]:
    """Return the T states of a ball.

    Args:
        ball: in any engine.
        state: (9,) at time zero.
        times: (T,) s, rising, multiples of the step.
        step: s, of the engine.
    """
    marks = np.rint(times / step).astype(int).tolist()
    ball.set(tuple(state.tolist()))
    path = []
    for number in range(1, marks[-1] + 1):
        ball.step()
        if number in marks:
            path.append(ball.state())
    return path
