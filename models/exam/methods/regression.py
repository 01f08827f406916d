"""Regressions: what a simulator leaves of shots, on what every hypothesis would change of it.

The methods that the exam compares come to one in different ways. Least squares need only the Gram
matrix of its columns, and those of resampled or left-out shots are sums of the shots' own.
"""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from scipy.cluster.hierarchy import fcluster, linkage

from models.ball.simulator import Simulator
from models.ball.types import Floats
from models.exam.answer import Answer, Finding, Found
from models.exam.design.questions import hideable
from models.exam.names import name_of
from models.gap.hypotheses import Hypothesis, hypotheses

ALIKE = 0.99  # cosine of columns that count as one

Places = tuple[int, ...]


def candidates(nominal: Simulator, withheld: Sequence[str]) -> tuple[Hypothesis, ...]:
    """Return what balls can show of the catalogue, the simulator's own numbers first."""
    shown = set(hideable())
    known = [one for one in hypotheses(nominal) if (one.effect, one.parameter) in shown]
    asked = (one for one in known if one.effect not in withheld)
    return tuple(sorted(asked, key=lambda one: not one.listed(nominal)))


@dataclass(frozen=True)
class Regression:
    """Residuals of B shots in units of the noise, and their slopes by K hypotheses.

    Attributes:
        columns: the hypotheses.
        grams: (B, K + 1, K + 1) of each shot's slopes and, last, residuals.
        classes: of each column, itself first and then those that it stands for.
    """

    columns: tuple[Hypothesis, ...]
    grams: Floats
    classes: tuple[tuple[Hypothesis, ...], ...]

    @classmethod
    def of(cls, columns: tuple[Hypothesis, ...], grams: Floats) -> "Regression":
        """Return the regression on hypotheses that the shots show, one of those that are alike."""
        total = grams.sum(axis=0)
        groups = list(_alike(total, _shown(columns, total)))
        members = {group[0]: tuple(columns[k] for k in group) for group in groups}
        whole = cls(columns, grams, tuple(members.get(k, ()) for k in range(len(columns))))
        return whole.among(tuple(members))

    @cached_property
    def total(self) -> Floats:
        """(K + 1, K + 1) Gram matrix of all shots."""
        total: Floats = self.grams.sum(axis=0)
        return total

    def among(self, some: Places) -> "Regression":
        """Return the regression on some of the hypotheses."""
        places = [*some, len(self.columns)]
        columns = tuple(self.columns[k] for k in some)
        classes = tuple(self.classes[k] for k in some)
        return Regression(columns, self.grams[:, places][:, :, places], classes)

    def estimates(self, some: Places, weights: Floats | None = None) -> Floats:
        """Return the least-squares values of some hypotheses, shots weighted by (B,) weights."""
        total = self.total if weights is None else np.tensordot(weights, self.grams, 1)
        places = list(some)
        return np.asarray(np.linalg.lstsq(total[np.ix_(places, places)], total[places, -1])[0])


def _shown(columns: tuple[Hypothesis, ...], total: Floats) -> Places:
    """Return places of hypotheses of which a possible value stands out of the noise."""
    reach = np.array([np.ptp(one.declaration.bounds) for one in columns])
    shown = np.flatnonzero(np.sqrt(np.diag(total)[:-1]) * reach > 1.0)
    return tuple(shown.tolist())


def _alike(total: Floats, shown: Places) -> Iterator[Places]:
    """Yield places of hypotheses whose columns point the same way."""
    if len(shown) < 2:
        yield from ((k,) for k in shown)
        return
    places = np.array(shown)
    norms = np.sqrt(np.diag(total))[places]
    cosines = total[np.ix_(places, places)] / np.outer(norms, norms)
    apart = np.maximum(1.0 - np.abs(cosines)[np.triu_indices(len(places), 1)], 0.0)
    member = fcluster(linkage(apart, "complete"), 1.0 - ALIKE, "distance")
    for group in dict.fromkeys(member):
        yield tuple(places[member == group].tolist())


def finding(
    nominal: Simulator,
    regression: Regression,
    chosen: Places,
    changes: Floats,
    intervals: Floats | None = None,
) -> Finding:
    """Return what a method says that names some hypotheses, those that explain most first.

    Args:
        nominal: simulator.
        regression: whose columns they are.
        chosen: their S places.
        changes: (S,) by how much their values differ from nominal.
        intervals: (S, 2) 95 % of these, where the method has them.
    """
    norms = np.sqrt(np.diag(regression.total))[list(chosen)]
    causes, amended = [], nominal
    for one in np.argsort(-np.abs(changes) * norms, kind="stable"):
        group = regression.classes[chosen[one]]
        value, (low, high) = group[0].value(nominal), group[0].declaration.bounds
        estimate = min(max(value + float(changes[one]), low), high)
        error = None if intervals is None else tuple(value + intervals[one])
        names = tuple(dict.fromkeys(name_of(member) for member in group))
        causes.append(Found(names[0], group[0].effect, group[0].parameter, estimate, error, names))
        amended = group[0].at(amended, estimate)
    ambiguous = any(len(cause.possible) > 1 for cause in causes)
    named: Answer = "ambiguous" if ambiguous else "named"
    return Finding(named if causes else "no_gap", tuple(causes), amended)
