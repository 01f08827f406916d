"""Measured balls for the predictors' tests."""

import numpy as np

from rallygap.models.ball.simulators import shipped
from rallygap.models.predictors.protocol import FUTURE_TIMES, HISTORY_TIMES, History

TRUTH = shipped("literature")
# Balls at their first measurement; the second one bounces inside the history.
FIRST = np.array(
    [
        [0.1, 1.2, 0.35, 0.3, -8.0, 1.0, -150.0, 20.0, 30.0],
        [-0.2, 0.9, 0.10, 0.2, -9.0, -2.5, -250.0, 0.0, 50.0],
        [0.0, 1.0, 0.40, -0.4, -6.0, -1.0, 200.0, -30.0, 0.0],
    ]
)


def observed(first=FIRST, noise=0.0, labelled=True, seed=0):
    """Histories of the balls and their (B, 60, 9) true futures."""
    generator = np.random.default_rng(seed)
    times = HISTORY_TIMES - HISTORY_TIMES[0]
    past = TRUTH.fly(first, times).states
    future = TRUTH.fly(first, times[-1] + FUTURE_TIMES).states
    states = np.concatenate([past[..., :3], past[..., 6:]], axis=-1)
    states[..., :3] += noise * generator.normal(size=past[..., :3].shape)
    mask = np.ones(states.shape, dtype=bool)
    mask[..., 3:] = labelled
    return History(np.where(mask, states, 0.0), mask), future
