"""Judging a forest: shots of matches that it has not seen, and what it makes of them."""

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from models.shot_quality.forest import grown
from models.shot_quality.settings import ForestSettings

Floats = NDArray[np.float64]
Booleans = NDArray[np.bool_]
Integers = NDArray[np.int64]
Judge = Callable[[Floats], Floats]
"""Returns the (B,) probabilities of (B, F) features."""
Method = Callable[[Floats, Booleans], Judge]
"""Learns from (B, F) features and what came of them."""

SHUFFLES = 5  # of a feature, for its importance


@dataclass(frozen=True)
class Fold:
    """Matches that are left out: their shots, and who has learned from all others.

    Attributes:
        rows: of the shots.
        judge: has not seen them.
    """

    rows: Integers
    judge: Judge


def base_rate(features: Floats, wins: Booleans) -> Judge:
    """Learn nothing but how often shots win."""
    share = wins.mean()
    return lambda shots: np.full(len(shots), share)


def logistic(features: Floats, wins: Booleans) -> Judge:
    """Fit a logistic regression on standardised features."""
    from sklearn.linear_model import LogisticRegression
    from sklearn.pipeline import make_pipeline
    from sklearn.preprocessing import StandardScaler

    fitted = make_pipeline(StandardScaler(), LogisticRegression()).fit(features, wins)
    return lambda shots: fitted.predict_proba(shots)[:, 1]


def forest(settings: ForestSettings, seed: int) -> Method:
    """Return what grows a forest."""
    return lambda features, wins: grown(features, wins, settings, seed).probabilities


def folds(
    features: Floats, wins: Booleans, matches: Integers, count: int, method: Method
) -> list[Fold]:
    """Leave out every match once, and learn from the others.

    Args:
        features: (B, F) of shots.
        wins: (B,) what came of them.
        matches: (B,) in which they were played; all shots of a match are left out together.
        count: into how many parts the matches are shared out.
        method: learns.

    Raises:
        ValueError: there are fewer matches than parts, or without one part all shots end alike.
    """
    from sklearn.model_selection import GroupKFold

    if len(np.unique(matches)) < count:
        raise ValueError(f"{len(np.unique(matches))} matches cannot be shared out to {count} parts")
    parts = []
    for known, rows in GroupKFold(count).split(features, wins, matches):
        if wins[known].all() or not wins[known].any():
            raise ValueError("without one part of the matches all shots end alike")
        parts.append(Fold(rows, method(features[known], wins[known])))
    return parts


def held_out(parts: list[Fold], features: Floats) -> Floats:
    """Return the (B,) probability of every shot, from who has not seen its match."""
    told = np.empty(len(features))
    for part in parts:
        told[part.rows] = part.judge(features[part.rows])
    return told


def roc_auc(wins: Booleans, told: Floats, weights: Any = None) -> float:
    """Return how often a shot that won has the higher probability; NaN where all end alike."""
    from sklearn.metrics import roc_auc_score

    counted = wins if weights is None else wins[weights > 0]
    if counted.all() or not counted.any():
        return np.nan
    return float(roc_auc_score(wins, told, sample_weight=weights))


def brier(wins: Booleans, told: Floats, weights: Any = None) -> float:
    """Return the mean squared error of probabilities: 0 is perfect."""
    return float(np.average((told - wins) ** 2, weights=weights))


def score(
    measure: Callable[..., float],
    wins: Booleans,
    told: Floats,
    matches: Integers,
    resamples: int,
    seed: int,
) -> tuple[float, float, float]:
    """Return a score and the ends of its 95 % interval, bootstrapped over matches.

    Args:
        measure: ``roc_auc`` or ``brier``.
        wins: (B,) what came of shots.
        told: (B,) probabilities.
        matches: (B,) in which they were played.
        resamples: of the matches; without any the interval is the score.
        seed: of the resamples.
    """
    found = measure(wins, told)
    names, member = np.unique(matches, return_inverse=True)
    even = np.full(len(names), 1 / len(names))
    drawn = np.random.default_rng(seed).multinomial(len(names), even, size=resamples)
    again = np.array([measure(wins, told, counts[member]) for counts in drawn])
    if not np.isfinite(again).any():
        return found, found, found
    low, high = np.nanquantile(again, [0.025, 0.975])
    return found, float(low), float(high)


def calibration(wins: Booleans, told: Floats, bins: int) -> list[tuple[int, float, float]]:
    """Return shots, mean probability and share that won, of equally many shots by probability."""
    order = np.argsort(told, kind="stable")
    parts = [rows for rows in np.array_split(order, bins) if len(rows)]
    return [(len(rows), float(told[rows].mean()), float(wins[rows].mean())) for rows in parts]


def importance(
    parts: list[Fold], features: Floats, wins: Booleans, random: np.random.Generator
) -> Floats:
    """Return (SHUFFLES, F) by how much the ROC-AUC falls where a feature is shuffled.

    Only shots of matches that were left out are asked for, each of who has not seen its match.
    """
    whole = roc_auc(wins, held_out(parts, features))
    falls = np.empty((SHUFFLES, features.shape[1]))
    for shuffle, column in np.ndindex(falls.shape):
        mixed = features.copy()
        mixed[:, column] = random.permutation(mixed[:, column])
        falls[shuffle, column] = whole - roc_auc(wins, held_out(parts, mixed))
    return falls
