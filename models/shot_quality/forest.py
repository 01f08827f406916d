"""The random forest that estimates how probably a shot wins the point."""

from typing import Any

import numpy as np
from sklearn.ensemble import RandomForestClassifier

from rallygap.models.ball.types import Bools, Floats
from rallygap.models.shot_quality.settings import ForestSettings


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
