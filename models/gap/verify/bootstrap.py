"""Resampled: how sure errors of predictions are, by shots drawn at random with replacement.

All that is compared is drawn together, so that what shots have in common does not count.
"""

import numpy as np

from models.ball.types import Floats

DRAWS = 2000


def root_mean_squares(squares: Floats) -> Floats:
    """Return (3, H) root mean squares of (3, B, H) squares, NaN where a shot has none."""
    there = np.isfinite(squares)
    count = np.maximum(there.sum(axis=1), 1)
    roots: Floats = np.sqrt(np.where(there, squares, 0.0).sum(axis=1) / count)
    return roots


def resampled(squares: Floats, seed: int) -> Floats:
    """Return the (D, 3, H) root mean squares of shots drawn at random, D times.

    Args:
        squares: (3, B, H) of B shots, NaN where one has none.
        seed: of the drawing.
    """
    shots = squares.shape[1]
    rows = np.random.default_rng(seed).integers(shots, size=(DRAWS, shots))
    times = np.zeros((DRAWS, shots))
    np.add.at(times, (np.arange(DRAWS)[:, None], rows), 1.0)
    there = np.isfinite(squares)
    count = np.maximum(np.einsum("db,kbh->dkh", times, there), 1.0)
    total = np.einsum("db,kbh->dkh", times, np.where(there, squares, 0.0))
    roots: Floats = np.sqrt(total / count)
    return roots


def interval(figures: Floats) -> tuple[float, float]:
    """Return 95 % of a figure of shots drawn at random; zeros where none of them has one."""
    known = figures[np.isfinite(figures)]
    low, high = np.quantile(known, [0.025, 0.975]) if len(known) else (0.0, 0.0)
    return round(float(low), 6), round(float(high), 6)
