"""Shares of the gap: how much of the gain of all causes each of them has (Shapley's value)."""

from itertools import permutations
from math import factorial

import numpy as np

from models.ball.types import Floats
from models.gap.inference.set_scores import SetScores
from models.gap.types import Indices, Places


def shares(set_scores: SetScores, causes: Places) -> dict[int, float]:
    """Return what each cause gains in twice the log likelihood, the sum being what all gain.

    It is the mean of what a cause adds to those before it, over the orders in which causes may be
    added. More causes never explain less, though some alone may gain nothing, where they would need
    implausible values.
    """
    orders = _orders(causes, set_scores.settings.name.max_orders)
    gains = [_gains(set_scores, orders[:, :size]) for size in range(1, len(causes) + 1)]
    best = np.maximum.accumulate([np.zeros(len(orders)), *gains])
    added = np.diff(best, axis=0).T
    return {k: float(added[orders == k].mean()) for k in causes}


def _orders(causes: Places, most: int) -> Indices:
    """Return (R, C) orders of the causes: all of them, or some at random where they are many."""
    if factorial(len(causes)) <= most:
        return np.array(list(permutations(causes)), dtype=np.int64)
    rows = np.tile(np.array(causes, dtype=np.int64), (most, 1))
    return np.random.default_rng(0).permuted(rows, axis=1)


def _gains(set_scores: SetScores, sets: Indices) -> Floats:
    distinct, places = np.unique(np.sort(sets, axis=1), axis=0, return_inverse=True)
    gains: Floats = set_scores.gains(distinct)[0][places.reshape(-1)]
    return gains
