"""Label readings: which spin labels are negated, and which are outliers and of no use.

A label is judged by the spin that the path of its shot tells without it (path_spins.py,
reading_mixture.py). The share of negated labels is the effect ``spin_sign_flip``; outliers are not
used.
"""

from collections.abc import Iterable
from dataclasses import dataclass, replace

import numpy as np
from scipy.stats import binomtest

from rallygap.models.gap.fit.refit import RefitResult
from rallygap.models.gap.fit.shots import Shots
from rallygap.models.gap.name.path_spins import PathSpins
from rallygap.models.gap.name.reading_mixture import NEGATED, OUTLIER, ReadingMixture
from rallygap.models.gap.settings import GapSettings
from rallygap.models.gap.types import Bools


@dataclass(frozen=True)
class LabelReadings:
    """How the labels of shots are read.

    Attributes:
        flipped: numbers of the shots whose labels are negated.
        labelled: how many shots have labels.
        settings: of the workflow.
        outliers: numbers of the shots whose labels are of no use.
        useless: whether no label is used, since labels err by more than half of the spin.
    """

    flipped: frozenset[int]
    labelled: int
    settings: GapSettings
    outliers: frozenset[int] = frozenset()
    useless: bool = False

    @property
    def share(self) -> float:
        """Of flipped labels in the labelled shots."""
        return float(len(self.flipped) / max(self.labelled, 1))

    @property
    def interval(self) -> tuple[float, float]:
        """Of the share (Wilson 1927)."""
        test = binomtest(len(self.flipped), max(self.labelled, 1))
        ends = test.proportion_ci(self.settings.confidence, "wilson")
        return float(ends.low), float(ends.high)

    @property
    def significant(self) -> bool:
        """Whether enough shots are flipped for a verdict."""
        return len(self.flipped) >= self.settings.name.min_flipped_labels

    @property
    def detectable(self) -> float:
        """The smallest share that would be found."""
        return self.settings.name.min_flipped_labels / max(self.labelled, 1)

    @property
    def doubtful(self) -> frozenset[int]:
        """Numbers of the shots whose labels are not as read."""
        return self.flipped | self.outliers

    def corrected(self, shots: Shots) -> Shots:
        """Return shots without outliers, flipped labels negated if significant, else left out."""
        if not self.significant:
            return self.left_out(shots)
        return self.negated(shots)

    def negated(self, shots: Shots) -> Shots:
        """Return shots without outliers and with the flipped labels negated."""
        sign = np.ones((len(shots), 1, 1))
        sign[sorted(self.flipped)] = -1.0
        return _without(replace(shots, labels=shots.labels * sign), self.outliers)

    def left_out(self, shots: Shots) -> Shots:
        """Return shots without the doubtful labels."""
        return _without(shots, self.doubtful)


def all_as_read(shots: Shots, settings: GapSettings) -> LabelReadings:
    """Return that every label is as read."""
    return LabelReadings(frozenset(), int(_labelled(shots).sum()), settings)


def read_labels(shots: Shots, fit: RefitResult, settings: GapSettings) -> LabelReadings:
    """Return how labels are read, by the paths of their shots about a fit's simulator."""
    as_read = all_as_read(shots, settings)
    if not as_read.labelled:
        return as_read
    found = PathSpins.of(shots, fit, settings.fit)
    if not len(found.rows):
        return as_read
    decided = ReadingMixture.of(found).readings(settings.decisive_gain(as_read.labelled))
    flipped, outliers = (
        frozenset(found.rows[decided == reading].tolist()) for reading in (NEGATED, OUTLIER)
    )
    return replace(as_read, flipped=flipped, outliers=outliers)


def without_labels(shots: Shots) -> Shots:
    """Return shots without any label."""
    return _without(shots, range(len(shots)))


def _labelled(shots: Shots) -> Bools:
    return np.asarray(shots.labelled.any(axis=1))


def _without(shots: Shots, some: Iterable[int]) -> Shots:
    """Return shots without the labels of some of them."""
    times, labels = shots.label_times.copy(), shots.labels.copy()
    times[sorted(some)] = labels[sorted(some)] = np.nan
    return replace(shots, label_times=times, labels=labels)
