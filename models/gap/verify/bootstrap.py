"""Paired bootstrap of prediction errors over shots (percentile intervals, Efron 1979)."""

import numpy as np

from rallygap.models.ball.types import Floats
from rallygap.models.gap.types import Indices


def root_mean_squares(squares: Floats) -> Floats:
    """Return (K, H) root mean squares over B shots of (K, B, H) squares.

    A square that is NaN is left out; the result is zero without any.
    """
    there = np.isfinite(squares)
    count = np.maximum(there.sum(axis=1), 1)
    roots: Floats = np.sqrt(np.where(there, squares, 0.0).sum(axis=1) / count)
    return roots


def drawn_shots(shots: int, draws: int) -> Indices:
    """Return (D, B) numbers of shots drawn at random, D times."""
    return np.random.default_rng(0).integers(shots, size=(draws, shots))


def resampled(squares: Floats, draws: int) -> Floats:
    """Return (D, K, H) root mean squares of (K, B, H) squares, of shots drawn at random D times."""
    rows = drawn_shots(squares.shape[1], draws)
    times = np.zeros(rows.shape)
    np.add.at(times, (np.arange(draws)[:, None], rows), 1.0)
    there = np.isfinite(squares)
    count = np.maximum(np.einsum("db,kbh->dkh", times, there), 1.0)
    total = np.einsum("db,kbh->dkh", times, np.where(there, squares, 0.0))
    roots: Floats = np.sqrt(total / count)
    return roots


def interval(values: Floats, confidence: float) -> tuple[float, float]:
    """Return the percentile interval of a statistic of resampled shots; zeros where it has none."""
    known = values[np.isfinite(values)]
    if not len(known):
        return 0.0, 0.0
    low, high = np.quantile(known, [(1 - confidence) / 2, (1 + confidence) / 2])
    return round(float(low), 6), round(float(high), 6)
