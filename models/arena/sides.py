"""The two sides of the table, and the change between table frame and player's frame."""

import numpy as np

from rallygap.models.ball.types import Floats

SIDES = ("near", "far")  # near is y < 0
DIRECTIONS = np.array([1.0, -1.0])  # sign of the direction along y in which each side plays


def switch_frame(states: Floats, directions: Floats) -> Floats:
    """Turn (B, ..., 9) states by 180 degrees about z where ``directions`` (B,) is -1.

    This maps table frame to player's frame and back.
    """
    signs = np.stack([directions, directions, np.ones_like(directions)] * 3, axis=-1)
    return states * signs.reshape(len(states), *[1] * (states.ndim - 2), 9)
