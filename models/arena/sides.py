"""The two sides of the table: a player sees it as the other one does, turned by half a turn."""

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]

SIDES = ("near", "far")  # near is y < 0
TOWARDS = np.array([1.0, -1.0])  # the way along y in which each side plays


def turned(states: Floats, ways: Floats) -> Floats:
    """Turn (B, ..., 9) states about the vertical, by half a turn where ``ways`` (B,) is -1."""
    signs = np.stack([ways, ways, np.ones_like(ways)] * 3, axis=-1)
    return states * signs.reshape(len(states), *[1] * (states.ndim - 2), 9)
