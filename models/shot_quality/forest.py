"""Winning probabilities by a random forest, and their cross-validation by whole matches."""

from collections.abc import Callable
from typing import Any

import numpy as np
from sklearn.base import clone
from sklearn.dummy import DummyClassifier
from sklearn.ensemble import RandomForestClassifier
from sklearn.linear_model import LogisticRegression
from sklearn.model_selection import GroupKFold
from sklearn.pipeline import make_pipeline
from sklearn.preprocessing import StandardScaler

from rallygap.models.ball.types import Bools, Floats, Integers
from rallygap.models.shot_quality.bootstrap import Estimate
from rallygap.models.shot_quality.settings import ForestSettings
from rallygap.models.support.bootstrap import resampled_counts

PERMUTATIONS = 5  # of each feature, for its importance

# The (N,) rows of the held-out shots, and the classifier that was trained on all other matches.
Fold = tuple[Integers, Any]
# From (B,) wins and probabilities and (R, B) weights to (R,) scores.
Metric = Callable[[Bools, Floats, Integers], Floats]


class Forest:
    """scikit-learn's random forest, with the range of the features that it was trained on.

    Args:
        features: (B, F) of the training shots.
        wins: (B,) whether each won.
        settings: of the forest.
        seed: of its random draws.
    """

    def __init__(self, features: Floats, wins: Bools, settings: ForestSettings, seed: int) -> None:
        self.classifier = forest_classifier(settings, seed).fit(features, wins)
        self.low, self.high = features.min(axis=0), features.max(axis=0)

    def probabilities(self, features: Floats) -> Floats:
        """Return the (B,) winning probabilities of shots (B, F); B may be zero."""
        return win_probabilities(self.classifier, features) if len(features) else np.zeros(0)

    def out_of_range(self, features: Floats) -> Bools:
        """Return (B, F) whether a feature lies outside the range of the training shots."""
        return (features < self.low) | (features > self.high)


def forest_classifier(settings: ForestSettings, seed: int) -> RandomForestClassifier:
    """Return the untrained classifier; one job, so that results do not depend on the machine."""
    return RandomForestClassifier(
        settings.trees, min_samples_leaf=settings.min_samples_leaf, random_state=seed, n_jobs=1
    )


def win_probabilities(classifier: Any, features: Floats) -> Floats:
    """Return the (B,) probabilities of a win that a scikit-learn classifier gives to (B, F) shots.

    They are zero where no training shot won: the classifier then has no class for it.
    """
    return classifier.predict_proba(features)[:, classifier.classes_].sum(axis=1)


def classifiers(settings: ForestSettings, seed: int) -> dict[str, Any]:
    """Return the untrained scikit-learn classifiers that are compared, by name."""
    return {
        "base_rate": DummyClassifier(strategy="prior"),
        "logistic": make_pipeline(StandardScaler(), LogisticRegression()),
        "forest": forest_classifier(settings, seed),
    }


def cross_validate(
    classifier: Any, features: Floats, wins: Bools, matches: Integers, folds: int
) -> list[Fold]:
    """Train a classifier once per fold, without the fold's matches.

    Args:
        classifier: scikit-learn's, untrained; it is cloned.
        features: (B, F) of shots.
        wins: (B,) whether each won.
        matches: (B,) in which it was played; all shots of a match are in one fold.
        folds: how many.

    Raises:
        ValueError: there are fewer matches than folds, or a training set has a single outcome.
    """
    count = len(np.unique(matches))
    if count < folds:
        raise ValueError(f"{count} matches cannot be split into {folds} folds")
    fitted = []
    for training, rows in GroupKFold(folds).split(features, wins, matches):
        if wins[training].all() or not wins[training].any():
            raise ValueError("all training shots of a fold have the same outcome")
        fitted.append((rows, clone(classifier).fit(features[training], wins[training])))
    return fitted


def held_out_probabilities(folds: list[Fold], features: Floats) -> Floats:
    """Return the (B,) probability of each shot, from the classifier that has not seen its match."""
    probabilities = np.empty(len(features))
    for rows, classifier in folds:
        probabilities[rows] = win_probabilities(classifier, features[rows])
    return probabilities


def roc_auc(wins: Bools, probabilities: Floats, weights: Integers) -> Floats:
    """Return (R,) areas under ROC curves; NaN where all shots of a row have the same outcome.

    The share of pairs of a shot that won and one that did not in which it has the larger
    probability, ties count half. scikit-learn's takes one row of weights at a time.

    Args:
        wins: (B,) whether each shot won.
        probabilities: (B,) predicted.
        weights: (R, B) how often each shot counts.
    """
    order = np.argsort(probabilities)
    _, starts = np.unique(probabilities[order], return_index=True)
    won, lost = (
        np.add.reduceat(weights[:, order] * chosen[order], starts, axis=1)
        for chosen in (wins, ~wins)
    )
    larger = (won * (np.cumsum(lost, axis=1) - 0.5 * lost)).sum(axis=1)
    pairs = won.sum(axis=1) * lost.sum(axis=1)
    with np.errstate(invalid="ignore"):
        return larger / pairs


def brier(wins: Bools, probabilities: Floats, weights: Integers) -> Floats:
    """Return (R,) mean squared errors of probabilities: 0 is perfect; arguments as above."""
    return weights @ (probabilities - wins) ** 2 / weights.sum(axis=1)


def score(metric: Metric, wins: Bools, probabilities: Floats) -> float:
    """Return the score of all shots, each counted once."""
    return float(metric(wins, probabilities, np.ones((1, len(wins)), dtype=np.int64))[0])


def bootstrap_score(
    metric: Metric, wins: Bools, probabilities: Floats, matches: Integers, resamples: int, seed: int
) -> Estimate:
    """Return a score, and its values on resamples of the matches.

    Args:
        metric: ``roc_auc`` or ``brier``.
        wins: (B,) whether each shot won.
        probabilities: (B,) predicted.
        matches: (B,) in which each was played.
        resamples: of the matches.
        seed: of the resamples.
    """
    names, member = np.unique(matches, return_inverse=True)
    counts = resampled_counts(len(names), resamples, np.random.default_rng(seed))
    resampled = metric(wins, probabilities, counts[:, member])
    return Estimate(score(metric, wins, probabilities), resampled)


def calibration(wins: Bools, probabilities: Floats, bins: int) -> list[tuple[int, float, float]]:
    """Return (shots, mean probability, share that won) of bins with equally many shots."""
    order = np.argsort(probabilities, kind="stable")
    parts = [rows for rows in np.array_split(order, bins) if len(rows)]
    return [
        (len(rows), float(probabilities[rows].mean()), float(wins[rows].mean())) for rows in parts
    ]


def permutation_importance(
    folds: list[Fold], features: Floats, wins: Bools, random: np.random.Generator
) -> Floats:
    """Return the (PERMUTATIONS, F) decrease of the held-out ROC-AUC when a feature is permuted."""
    reference = score(roc_auc, wins, held_out_probabilities(folds, features))
    decrease = np.empty((PERMUTATIONS, features.shape[1]))
    for repeat, column in np.ndindex(decrease.shape):
        permuted = features.copy()
        permuted[:, column] = random.permutation(permuted[:, column])
        probabilities = held_out_probabilities(folds, permuted)
        decrease[repeat, column] = reference - score(roc_auc, wins, probabilities)
    return decrease
