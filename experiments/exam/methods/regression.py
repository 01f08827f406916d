"""Linear regression of residuals on the catalogue's parameters, from Gram matrices of the shots.

Least squares need only the Gram matrix of the columns; those of resampled or left-out shots are
sums of the shots' own.
"""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from scipy.cluster.hierarchy import fcluster, linkage

from experiments.exam.design.parameters import hideable
from experiments.exam.interface import Answer, NamedCause
from rallygap.models.ball.simulator import Simulator
from rallygap.models.ball.types import Floats
from rallygap.models.gap.hypotheses import Hypothesis, hypotheses
from rallygap.models.gap.verdict import Answer as Conclusion

MINIMUM_COSINE = 0.99  # of columns that one regressor stands for

Indices = tuple[int, ...]


def candidates(nominal: Simulator, withheld: Sequence[str]) -> tuple[Hypothesis, ...]:
    """Return the parameters that shots can show, the simulator's own first."""
    shown = set(hideable())
    known = [c for c in hypotheses(nominal) if c in shown and c.effect not in withheld]
    return tuple(sorted(known, key=lambda column: not column.listed(nominal)))


@dataclass(frozen=True)
class Regression:
    """Residuals of B shots in units of the noise, and their slopes by K parameters."""

    columns: tuple[Hypothesis, ...]  # the parameters
    grams: Floats  # (B, K + 1, K + 1) of each shot's slopes and, last, residuals
    # of each column, itself first and then the parameters that it stands for
    classes: tuple[tuple[Hypothesis, ...], ...]

    @classmethod
    def of(cls, columns: tuple[Hypothesis, ...], grams: Floats) -> "Regression":
        """Return the regression on parameters that the shots show, one of each parallel class."""
        total = grams.sum(axis=0)
        # Observable: some value within bounds raises the parameter above the noise.
        reach = np.array([np.ptp(column.declaration.bounds) for column in columns])
        observable = np.flatnonzero(np.sqrt(np.diag(total)[:-1]) * reach > 1.0)
        groups = list(_parallel(total, tuple(observable.tolist())))
        members = {group[0]: tuple(columns[k] for k in group) for group in groups}
        whole = cls(columns, grams, tuple(members.get(k, ()) for k in range(len(columns))))
        return whole.restricted(tuple(members))

    @cached_property
    def total(self) -> Floats:
        """(K + 1, K + 1) Gram matrix of all shots."""
        return self.grams.sum(axis=0)

    def restricted(self, indices: Indices) -> "Regression":
        """Return the regression on the columns at ``indices``."""
        kept = [*indices, len(self.columns)]
        columns = tuple(self.columns[k] for k in indices)
        classes = tuple(self.classes[k] for k in indices)
        return Regression(columns, self.grams[:, kept][:, :, kept], classes)

    def estimates(self, indices: Indices, weights: Floats | None = None) -> Floats:
        """Return the least-squares values of some columns, with (B,) weights of the shots."""
        total = self.total if weights is None else np.tensordot(weights, self.grams, 1)
        terms = list(indices)
        return np.asarray(np.linalg.lstsq(total[np.ix_(terms, terms)], total[terms, -1])[0])


def _parallel(total: Floats, indices: Indices) -> Iterator[Indices]:
    """Yield groups of columns that are nearly parallel."""
    if len(indices) < 2:
        yield from ((k,) for k in indices)
        return
    terms = np.array(indices)
    norms = np.sqrt(np.diag(total))[terms]
    cosines = total[np.ix_(terms, terms)] / np.outer(norms, norms)
    distances = np.maximum(1.0 - np.abs(cosines)[np.triu_indices(len(terms), 1)], 0.0)
    member = fcluster(linkage(distances, "complete"), 1.0 - MINIMUM_COSINE, "distance")
    for group in dict.fromkeys(member):
        yield tuple(terms[member == group].tolist())


def answer(
    nominal: Simulator,
    regression: Regression,
    chosen: Indices,
    changes: Floats,
    intervals: Floats | None = None,
) -> Answer:
    """Return the answer that names some columns, those that explain most first.

    Args:
        nominal: simulator.
        regression: with the columns.
        chosen: their S places.
        changes: (S,) of their values from nominal.
        intervals: (S, 2) 95 % confidence intervals of the changes, if there are any.
    """
    norms = np.sqrt(np.diag(regression.total))[list(chosen)]
    causes, amended, ambiguous = [], nominal, False
    for place in np.argsort(-np.abs(changes) * norms, kind="stable"):
        group = regression.classes[chosen[place]]
        value, (low, high) = group[0].value(nominal), group[0].declaration.bounds
        estimate = min(max(value + float(changes[place]), low), high)
        cause = NamedCause(
            identity=group[0].identity,
            estimate=estimate,
            interval=None if intervals is None else tuple(value + intervals[place]),
            possible=tuple(member.identity for member in group),
        )
        causes.append(cause)
        amended = group[0].at(amended, estimate)
        ambiguous = ambiguous or len({member.quantity for member in group}) > 1
    named: Conclusion = "ambiguous" if ambiguous else "named"
    return Answer(named if causes else "no_gap", tuple(causes), amended)
