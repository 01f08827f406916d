"""Explanations: the fewest hypotheses that leave nothing significant, and what would do as well.

All is linear about one fit, so that thousands of explanations are weighed at no cost. An
explanation is a set of hypotheses whose values differ from the *nominal* simulator's; all others
keep theirs. It is worth what it gains in twice the log likelihood, less a price a hypothesis: the
square of the deviation that the largest of all hypotheses reaches by chance at the level asked for.
So one cause goes before two that explain as much: a clock that runs slow before a wrong gravity and
a spin sensor whose gain just fits it.
"""

from collections.abc import Iterable, Sequence
from dataclasses import dataclass

import numpy as np
from scipy.stats import norm

from models.ball.simulator import Simulator
from models.ball.types import Floats
from models.gap.evidence import Evidence, Indices, Tested, familywise
from models.gap.refit import Refitted
from models.gap.shots import Bools

MOST_CAUSES = 5
BEAM = 150  # sets of a size that are carried on
MOST_ALIKE = 100.0  # by how much others may inflate the variance of a cause's value
WITNESSES = 2.5  # shots that must say as much as all: no name rests on one or two
BEYOND = 3.0  # standard errors that an estimate may lie outside of what makes physical sense

Places = tuple[int, ...]


def from_nominal(found: Refitted, nominal: Simulator, withheld: Sequence[str] = ()) -> Evidence:
    """Return the evidence of refitted shots about departures from the nominal simulator.

    Args:
        found: the shots about a simulator nearby.
        nominal: whose values count as no departure.
        withheld: effects that are not in question.
    """
    evidence = found.evidence
    kept = [k for k, one in enumerate(evidence.columns) if one.effect not in withheld]
    columns = tuple(evidence.columns[k] for k in kept)
    information = evidence.information[:, kept][:, :, kept]
    moved = np.array([one.value(found.simulator) - one.value(nominal) for one in columns])
    scores = evidence.scores[:, kept] + information @ moved
    listed = np.array([one.listed(nominal) for one in columns], dtype=bool)
    return Evidence(columns, listed, scores, information)


@dataclass(frozen=True)
class Explainer:
    """Weighs explanations.

    Attributes:
        evidence: about departures from the nominal simulator.
        nominal: it.
        level: chance of a false name in a set without any gap.
    """

    evidence: Evidence
    nominal: Simulator
    level: float

    @property
    def candidates(self) -> Places:
        """Hypotheses that these shots could show if nothing else were wrong."""
        return self.evidence.decidable((), WITNESSES)

    @property
    def price(self) -> float:
        """What a hypothesis must gain to be worth its place."""
        return float(norm.isf(self.level / (2 * max(len(self.candidates), 1))) ** 2)

    def gains(self, sets: Indices) -> tuple[Floats, Floats]:
        """Return the (R,) gains of (R, S) sets of hypotheses, and their (R, S) estimates."""
        total, scores = self.evidence.total, self.evidence.scores.sum(axis=0)
        inner = total[sets[:, :, None], sets[:, None, :]]
        size = sets.shape[1]
        inner = inner + 1e-9 * np.einsum("rii->ri", inner)[..., None] * np.eye(size)
        estimates = np.linalg.solve(inner, scores[sets][..., None])[..., 0]
        gains = (estimates * scores[sets]).sum(axis=1)
        return np.where(self._possible(sets, inner, estimates), gains, -np.inf), estimates

    def _possible(self, sets: Indices, inner: Floats, estimates: Floats) -> Bools:
        """Return which (R,) sets have values that make sense, and are told apart."""
        columns = self.evidence.columns
        start = np.array([one.value(self.nominal) for one in columns])[sets]
        bounds = np.array([one.declaration.bounds for one in columns])[sets]
        variance = np.maximum(np.einsum("rii->ri", np.linalg.inv(inner)), 0.0)
        value, error = start + estimates, BEYOND * np.sqrt(variance)
        within = (value > bounds[..., 0] - error) & (value < bounds[..., 1] + error)
        apart = variance * np.einsum("rii->ri", inner) < MOST_ALIKE
        possible: Bools = (within & apart).all(axis=1)
        return possible

    def best(self, always: Places, barred: Iterable[int]) -> Places:
        """Return the explanation of the largest worth, by beam search.

        Args:
            always: hypotheses that are part of it.
            barred: hypotheses that are not.
        """
        free = [k for k in self.candidates if k not in always and k not in set(barred)]
        beam, best, worth = [always], always, self.gain(always)
        for size in range(len(always) + 1, len(always) + MOST_CAUSES + 1):
            grown = {tuple(sorted((*one, k))) for one in beam for k in free if k not in one}
            if not grown:
                break
            sets = np.array(sorted(grown))
            gains, _ = self.gains(sets)
            order = np.argsort(-self._preferred(sets, gains), kind="stable")[:BEAM]
            beam = [tuple(sets[place].tolist()) for place in order]
            leader = float(gains[order[0]]) - self.price * (size - len(always))
            if leader > worth:
                best, worth = beam[0], leader
        return best

    def gain(self, one: Places) -> float:
        """Return what one set of hypotheses gains in twice the log likelihood."""
        return float(self.gains(np.array([one]))[0][0]) if one else 0.0

    def _preferred(self, sets: Indices, gains: Floats) -> Floats:
        """Return gains by which to rank: of those exactly alike the simulator's own go first."""
        preferred: Floats = gains + 1e-3 * self.evidence.listed[sets].sum(axis=1)
        return preferred

    def beside(self, k: int, causes: Places) -> Places:
        """Return what is free when a hypothesis is tested beside the causes.

        A missing effect must stand beside all that the simulator's own numbers could absorb; one
        of these beside the causes alone, since a wrong number is a simpler cause than two.
        """
        own = () if self.evidence.listed[k] else self.evidence.free
        return tuple(sorted({*own, *causes} - {k}))

    def tests(self, causes: Places) -> dict[int, Tested]:
        """Return the tests of all candidates, each beside the causes."""
        tested = {k: self.evidence.tested([k], self.beside(k, causes)) for k in self.candidates}
        decided = {k: one for k, one in tested.items() if self._decides(k, one)}
        return decided

    def _decides(self, k: int, test: Tested) -> bool:
        return self.evidence.decides(test, WITNESSES) or bool(self.evidence.listed[k])

    def rivals(self, k: int, causes: Places) -> Places:
        """Return the class of a cause: the hypotheses that in its place explain about as much.

        One is excluded that explains less by the square of a deviation that a normal number
        exceeds with the chance ``level``; so no rival excludes the true cause with a larger one.
        """
        others = tuple(one for one in causes if one != k)
        seen = [one for one in np.flatnonzero(self.evidence.seen).tolist() if one not in causes]
        if not seen:
            return (k,)
        sets = np.array([(*others, one) for one in seen])
        gains, _ = self.gains(sets)
        close = gains > self.gain(causes) - norm.isf(self.level) ** 2
        return (k, *(one for one, near in zip(seen, close, strict=True) if near))


@dataclass(frozen=True)
class Explanation:
    """A set of causes, each with the chance that the largest of all is as large by chance."""

    causes: Places
    p_values: dict[int, float]


def explained(explainer: Explainer, always: Places = ()) -> Explanation:
    """Return the best explanation all of whose causes are significant and hold on other shots.

    Args:
        explainer: weighs them.
        always: causes that are known.
    """
    barred: set[int] = set()
    while True:
        causes = explainer.best(always, barred)
        tests = explainer.tests(causes)
        chances = dict(zip(tests, familywise(list(tests.values())), strict=True)) if tests else {}
        chances |= {k: 1.0 for k in causes if k in tests and tests[k].held_out_gain <= 0.0}
        weak = [k for k in causes if k not in always and chances.get(k, 1.0) > explainer.level]
        if not weak:
            return Explanation(causes, {k: float(chances.get(k, 0.0)) for k in causes})
        barred.add(max(weak, key=lambda k: chances.get(k, 1.0)))
