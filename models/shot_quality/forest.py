"""Forest: how often shots like these win, by a random forest that is kept as plain arrays."""

from collections.abc import Mapping
from dataclasses import dataclass, fields
from typing import Any

import numpy as np
from numpy.typing import NDArray

from models.shot_quality.settings import ForestSettings

Floats = NDArray[np.float64]
Booleans = NDArray[np.bool_]
Integers = NDArray[np.int64]

INDICES = ("roots", "left", "right", "feature")  # among a forest's arrays


@dataclass(frozen=True)
class Forest:
    """T trees of N nodes in all, and what they have seen of F features.

    Attributes:
        roots: (T,) the first node of each tree.
        left: (N,) node for shots whose feature is at most the threshold; a leaf's is itself.
        right: (N,) node for the others; a leaf's is itself.
        feature: (N,) on which a node decides.
        threshold: (N,).
        share: (N,) of the training shots at the node that won.
        low: (F,) the smallest value of each feature among all training shots.
        high: (F,) the largest.
    """

    roots: Integers
    left: Integers
    right: Integers
    feature: Integers
    threshold: Floats
    share: Floats
    low: Floats
    high: Floats

    def probabilities(self, features: Floats) -> Floats:
        """Return how probably shots (B, F) win: (B,), to the last bit what scikit-learn says."""
        seen = features.astype(np.float32)  # as scikit-learn compares them
        total = np.zeros(len(seen))
        for root in self.roots:
            total += self.share[self._leaves(root, seen)]
        total /= len(self.roots)
        return total

    def unlike(self, features: Floats) -> Booleans:
        """Return (B, F) whether a feature is beyond all that the forest was trained on."""
        return (features < self.low) | (features > self.high)

    def to_arrays(self) -> dict[str, NDArray[Any]]:
        """Return all numbers by name."""
        return {field.name: getattr(self, field.name) for field in fields(self)}

    @classmethod
    def from_arrays(cls, arrays: Mapping[str, NDArray[Any]]) -> "Forest":
        """Return the forest that gave ``arrays``.

        Raises:
            ValueError: they are not those of a forest.
        """
        names = {field.name for field in fields(cls)}
        if set(arrays) != names:
            raise ValueError(f"a forest has the arrays {', '.join(sorted(names))}")
        forest = cls(**arrays)
        forest._check_numbers()
        forest._check_ways()
        return forest

    def _leaves(self, root: int, seen: NDArray[np.float32]) -> Integers:
        """Return the (B,) leaves of one tree."""
        rows = np.arange(len(seen))
        nodes = np.full(len(seen), root)
        while True:
            goes_left = seen[rows, self.feature[nodes]] <= self.threshold[nodes]
            following = np.where(goes_left, self.left[nodes], self.right[nodes])
            if (following == nodes).all():
                return nodes
            nodes = following

    def _check_numbers(self) -> None:
        """Refuse arrays that are no rows of such numbers."""
        for name, array in self.to_arrays().items():
            kind = np.int64 if name in INDICES else np.float64
            if array.ndim != 1 or array.dtype != kind or not np.isfinite(array).all():
                raise ValueError(f"{name} is no row of finite {kind.__name__} numbers")
        if not ((self.share >= 0) & (self.share <= 1)).all():
            raise ValueError("a share is not between 0 and 1")

    def _check_ways(self) -> None:
        """Refuse trees that lead nowhere, or in circles."""
        nodes = np.arange(len(self.share))
        shapes = {one.shape for one in (self.left, self.right, self.feature, self.threshold)}
        if shapes != {nodes.shape} or self.low.shape != self.high.shape or not len(self.roots):
            raise ValueError("the arrays of a forest have different lengths")
        for one in (self.left, self.right):
            leads_on = (one > nodes) & (one < len(nodes))
            if not (leads_on | ((self.left == nodes) & (self.right == nodes))).all():
                raise ValueError("a node leads to none after it")
        within = (self.feature >= 0) & (self.feature < len(self.low))
        if not within.all() or not ((self.roots >= 0) & (self.roots < len(nodes))).all():
            raise ValueError("a node asks for a feature that there is not")


def grown(features: Floats, wins: Booleans, settings: ForestSettings, seed: int) -> Forest:
    """Train a random forest.

    Args:
        features: (B, F) of shots.
        wins: (B,) what came of them.
        settings: of the forest.
        seed: of its draws.
    """
    classifier = _classifier(settings, seed).fit(features, wins)
    trees = [one.tree_ for one in classifier.estimators_]
    firsts = np.cumsum([0, *(tree.node_count for tree in trees)])[:-1]
    won = np.flatnonzero(classifier.classes_)
    parts = [_planted(tree, first, won) for tree, first in zip(trees, firsts, strict=True)]
    left, right, feature, threshold, share = map(np.concatenate, zip(*parts, strict=True))
    ends = features.min(axis=0), features.max(axis=0)
    return Forest(firsts, left, right, feature, threshold, share, *ends)


def _classifier(settings: ForestSettings, seed: int) -> Any:
    from sklearn.ensemble import RandomForestClassifier

    return RandomForestClassifier(
        settings.trees, min_samples_leaf=settings.smallest_leaf, random_state=seed, n_jobs=1
    )


def _planted(
    tree: Any, first: int, won: Integers
) -> tuple[Integers, Integers, Integers, Floats, Floats]:
    """Return the columns of scikit-learn's tree whose nodes are counted from ``first``."""
    own = first + np.arange(tree.node_count, dtype=np.int64)
    leaf = tree.children_left < 0
    left, right = (
        np.where(leaf, own, first + side.astype(np.int64))
        for side in (tree.children_left, tree.children_right)
    )
    share = tree.value[:, 0, won].sum(axis=1)  # zero where no shot of the training won
    return left, right, np.maximum(tree.feature, 0).astype(np.int64), tree.threshold, share
