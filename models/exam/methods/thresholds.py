"""Thresholds: those with which a method does best on development sets."""

from collections.abc import Callable, Sequence

import numpy as np

from models.ball.types import Floats
from models.exam.methods.regression import Places, Regression
from models.exam.names import name_of

# The places of the columns that a method names with a threshold.
Naming = Callable[[Regression, float], Places]
# A regression, and the name of what is hidden in its shots, if anything is.
Development = tuple[Regression, str | None]


def best_threshold(
    naming: Naming, sets: Sequence[Development], thresholds: Sequence[float]
) -> float:
    """Return the threshold of the largest accuracy; of equal ones the first."""
    return max(thresholds, key=lambda threshold: accuracy(naming, sets, threshold))


def accuracy(naming: Naming, sets: Sequence[Development], threshold: float) -> float:
    """Return the mean of two shares, so that clean sets count as much as all others.

    Of clean sets those in which nothing is named; of the others those in which one class of causes
    is named, and the right one.
    """
    right: dict[bool, list[bool]] = {True: [], False: []}
    for regression, hidden in sets:
        named = [regression.classes[k] for k in naming(regression, threshold)]
        names = [{name_of(one) for one in group} for group in named]
        found = len(names) == 1 and hidden in names[0]
        right[hidden is None].append(found if hidden else not names)
    return float(np.mean([np.mean(some) for some in right.values() if some]))


def with_hidden(grams: Floats, place: int, size: float) -> Floats:
    """Return the (B, K + 1, K + 1) Gram matrices of the same shots under an effect.

    Args:
        grams: of K hypotheses and residuals.
        place: of the hypothesis that is true.
        size: by how much its value differs from nominal; to first order.
    """
    change = np.eye(grams.shape[-1])
    change[place, -1] = size
    hidden: Floats = change.T @ grams @ change
    return hidden
