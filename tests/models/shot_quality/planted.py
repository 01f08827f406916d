"""Shots with a known rule: the larger vy at the bounce, the more of them win."""

import numpy as np

from rallygap.models.shot_quality.settings import ForestSettings
from rallygap.models.shot_quality.shots import FEATURES

SETTINGS = ForestSettings(trees=20, min_samples_leaf=10)


def planted(count=600, seed=0, rule=True):
    """Features, outcomes and matches of ``count`` shots; without the rule outcomes are random."""
    random = np.random.default_rng(seed)
    features = random.normal(size=(count, len(FEATURES)))
    probability = 1 / (1 + np.exp(-4 * features[:, 3])) if rule else np.full(count, 0.5)
    return features, random.random(count) < probability, np.arange(count) // 6
