"""Shots by a planted rule: the faster they come down, the more of them win."""

import numpy as np

from models.shot_quality.settings import ForestSettings
from models.shot_quality.shots import FEATURES

SETTINGS = ForestSettings(trees=20, smallest_leaf=10)


def planted(count=600, seed=0, rule=True):
    """Features, what came of them, and the match of each of ``count`` shots."""
    random = np.random.default_rng(seed)
    features = random.normal(size=(count, len(FEATURES)))
    chance = 1 / (1 + np.exp(-4 * features[:, 3])) if rule else np.full(count, 0.5)
    return features, random.random(count) < chance, np.arange(count) // 6
