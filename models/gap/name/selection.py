"""Explanations: the fewest hypotheses that leave nothing significant, and what would do as well.

All is linear about one fit, so that thousands of explanations are weighed at no cost. An
explanation is a set of hypotheses whose values differ from the *nominal* simulator's; all others
keep theirs. It is worth what it gains in twice the log likelihood, less a price a hypothesis: the
square of the deviation that the largest of all hypotheses reaches by chance at the level asked for.
So one cause goes before two that explain as much: a clock that runs slow before a wrong gravity and
a spin sensor whose gain just fits it. A missing effect that the simulator's own numbers can absorb,
if several of them change together, goes before two of these, but after one that explains about as
much.
"""

from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from scipy.stats import norm

from models.ball.simulator import Simulator
from models.ball.types import Floats
from models.gap.fit.refit import Refitted
from models.gap.inference.score_test import Evidence, Tested, familywise
from models.gap.inference.set_scores import Scales
from models.gap.types import Indices, Places

AT_ONCE = 5  # causes by which explanations about one fit may grow
BEAM = 150  # sets of a size that are carried on, at most ...
WORK = 750  # ... and of so many causes in all
WITNESSES = 2.5  # shots that must say as much as all: no name rests on one or two
ALIKE = 1e-3  # of twice the log likelihood, which the simulator's own numbers have as an advantage


def from_nominal(found: Refitted, nominal: Simulator, withheld: Sequence[str] = ()) -> Evidence:
    """Return the evidence of refitted shots about departures from the nominal simulator.

    Args:
        found: the shots about a simulator nearby.
        nominal: whose values count as no departure.
        withheld: effects that are not in question.
    """
    evidence = Evidence.of(found.linear, found.components)
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
        refitted: hypotheses that the shots were refitted with.
    """

    evidence: Evidence
    nominal: Simulator
    level: float
    refitted: Places = ()

    @cached_property
    def scales(self) -> Scales:
        """What weighs sets of hypotheses."""
        return Scales.of(self.evidence, self.nominal, self.refitted)

    @cached_property
    def candidates(self) -> Places:
        """Hypotheses that these shots could show if nothing else were wrong."""
        return self.evidence.decidable((), WITNESSES)

    @cached_property
    def price(self) -> float:
        """What a hypothesis must gain to be worth its place."""
        return float(norm.isf(self.level / (2 * max(len(self.candidates), 1))) ** 2)

    @property
    def tolerance(self) -> float:
        """By how much less explains about as much: what chance takes away at the level asked for.

        So no rival excludes the true cause with a larger chance than the level.
        """
        return float(norm.isf(self.level) ** 2)

    @cached_property
    def absorbed(self) -> Places:
        """Missing effects that the simulator's own numbers can absorb on these shots."""
        told = self.evidence.decidable(self.evidence.free, WITNESSES)
        return tuple(k for k in self.candidates if not (self.evidence.listed[k] or k in told))

    @cached_property
    def handicaps(self) -> Floats:
        """(K,) what hypotheses must gain beyond the simulator's own numbers to go before them."""
        handicaps = np.where(self.evidence.listed, 0.0, ALIKE)
        handicaps[list(self.absorbed)] = self.tolerance
        return handicaps

    def best(self, always: Places, barred: Iterable[int], most: int) -> Places:
        """Return the explanation of the largest worth, by beam search.

        Args:
            always: hypotheses that are part of it.
            barred: hypotheses that are not.
            most: hypotheses that it may have.
        """
        free = [k for k in self.candidates if k not in always and k not in set(barred)]
        beam, best = np.array([always], dtype=np.int64), always
        worth = self.gain(always) - self.handicaps[list(always)].sum()
        for size in range(len(always) + 1, min(most, len(always) + len(free)) + 1):
            beam, leader = self._grown(beam, free)
            leader -= self.price * (size - len(always))
            if leader > worth:
                best, worth = tuple(beam[0].tolist()), leader
        return best

    def _grown(self, beam: Indices, free: Sequence[int]) -> tuple[Indices, float]:
        """Return the best sets of one more hypothesis, best first, and the gain of the first.

        Gains are those less the handicaps.
        """
        handicaps = self.handicaps[beam].sum(axis=1)[:, None] + self.handicaps[free]
        gains = self.scales.grown(beam, free) - handicaps
        order = np.argsort(-gains, axis=None, kind="stable")
        parents, further = np.unravel_index(order, gains.shape)
        sets = np.sort(np.column_stack([beam[parents], np.array(free)[further]]), axis=1)
        sets = sets[(np.diff(sets, axis=1) > 0).all(axis=1)]
        width = min(BEAM, max(WORK // sets.shape[1], 1))
        sets = sets[: width * sets.shape[1]]  # a set has as many parents as members, at most
        _, first = np.unique(sets, axis=0, return_index=True)
        return sets[np.sort(first)[:width]], float(gains.flat[order[0]])

    def gain(self, one: Places) -> float:
        """Return what one set of hypotheses gains in twice the log likelihood."""
        return float(self.scales.gains(np.array([one]))[0][0]) if one else 0.0

    def beside(self, k: int, causes: Places) -> Places:
        """Return what is free when a hypothesis is tested beside the causes.

        A missing effect must stand beside the simulator's own numbers, unless they can absorb it
        whatever its size; one of these beside the causes alone, since a wrong number is a simpler
        cause than two.
        """
        alone = self.evidence.listed[k] or k in self.absorbed
        own = () if alone else self.evidence.free
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

        Where the simulator's own numbers can absorb it, those that do so together are among them.
        """
        others = tuple(one for one in causes if one != k)
        seen = [one for one in np.flatnonzero(self.evidence.seen).tolist() if one not in causes]
        if not seen:
            return (k,)
        sets = np.array([(*others, one) for one in seen])
        gains, _ = self.scales.gains(sets)
        close = gains > self.gain(causes) - self.tolerance
        single = (one for one, near in zip(seen, close, strict=True) if near)
        return (k, *dict.fromkeys((*single, *self._together(k, causes))))

    def _together(self, k: int, causes: Places) -> Places:
        """Return the simulator's own numbers that together explain about as much as one cause."""
        if k not in self.absorbed:
            return ()
        others = tuple(one for one in causes if one != k)
        missing = np.flatnonzero(~self.evidence.listed).tolist()
        found = self.best(others, missing, len(others) + AT_ONCE)
        near = self.gain(found) > self.gain(causes) - self.tolerance
        return tuple(one for one in found if one not in others) if near else ()


@dataclass(frozen=True)
class Explanation:
    """A set of causes, each with the chance that the largest of all is as large by chance.

    It is 1 for known causes of which the shots decide nothing any more.
    """

    causes: Places
    p_values: dict[int, float]


def explained(explainer: Explainer, always: Places = (), most: int = AT_ONCE) -> Explanation:
    """Return the best explanation all of whose causes are significant and hold on other shots.

    Args:
        explainer: weighs them.
        always: causes that are known.
        most: causes that it may have.
    """
    barred: set[int] = set()
    while True:
        causes = explainer.best(always, barred, most)
        tests = explainer.tests(causes)
        chances = dict(zip(tests, familywise(list(tests.values())), strict=True)) if tests else {}
        chances |= {k: 1.0 for k in causes if k in tests and tests[k].held_out_gain <= 0.0}
        weak = [k for k in causes if k not in always and chances.get(k, 1.0) > explainer.level]
        if not weak:
            return Explanation(causes, {k: float(chances.get(k, 1.0)) for k in causes})
        barred.add(max(weak, key=lambda k: chances.get(k, 1.0)))
