"""Selection: the fewest hypotheses that explain the shots, and what would explain them as well.

All is linear about one fit, so that thousands of sets are scored at once. An explanation is a set
of k hypotheses whose values differ from those of the *nominal* simulator. Its penalised score is
``2 dlog L - lambda k``, with lambda the squared critical value of the largest of all candidates at
the level asked for (the risk inflation criterion, Foster and George 1994). So one cause is
preferred to two that explain as much: a slow clock to a wrong gravity and a spin sensor whose gain
just fits it. A missing effect that the listed parameters of the simulator can absorb, if several of
them change together, is preferred to two of these, but not to one that explains about as much.
"""

from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from models.ball.simulator import Simulator
from models.ball.types import Floats
from models.gap.fit.refit import RefitResult
from models.gap.inference.score_test import Evidence, ScoreTest, familywise_p_values
from models.gap.inference.set_scores import SetScores
from models.gap.inference.set_search import SetSearch
from models.gap.settings import GapSettings, NameSettings
from models.gap.types import Places


def evidence_about(
    found: RefitResult,
    nominal: Simulator,
    settings: GapSettings,
    withheld: Sequence[str] = (),
) -> Evidence:
    """Return the evidence of refitted shots about departures from the nominal simulator.

    Args:
        found: the shots about a simulator nearby.
        nominal: whose values count as no departure.
        settings: of the workflow.
        withheld: effects that are not in question.
    """
    evidence = Evidence.of(found.linear, found.noise_estimate, settings)
    kept = [k for k, one in enumerate(evidence.columns) if one.effect not in withheld]
    columns = tuple(evidence.columns[k] for k in kept)
    information = evidence.information[:, kept][:, :, kept]
    moved = np.array([one.value(found.simulator) - one.value(nominal) for one in columns])
    scores = evidence.scores[:, kept] + information @ moved
    listed = np.array([one.listed(nominal) for one in columns], dtype=bool)
    return Evidence(columns, listed, scores, information, settings)


@dataclass(frozen=True)
class Explainer:
    """Weighs explanations.

    Attributes:
        evidence: about departures from the nominal simulator.
        nominal: it.
        refitted: hypotheses that the shots were refitted with.
    """

    evidence: Evidence
    nominal: Simulator
    refitted: Places = ()

    @property
    def settings(self) -> NameSettings:
        """Of naming."""
        return self.evidence.settings.name

    @cached_property
    def set_scores(self) -> SetScores:
        """What weighs sets of hypotheses."""
        return SetScores.of(self.evidence, self.nominal, self.refitted)

    @cached_property
    def candidates(self) -> Places:
        """Hypotheses that these shots could show if nothing else were wrong."""
        return self.evidence.decidable((), self.settings.min_sample_size)

    @cached_property
    def penalty(self) -> float:
        """What a hypothesis must gain to be worth its place."""
        return self.evidence.settings.penalty(len(self.candidates))

    @property
    def tolerance(self) -> float:
        """By how much less explains about as much: what chance takes away at the level asked for.

        So no rival excludes the true cause with a larger chance than the level.
        """
        return self.evidence.settings.tolerance

    @cached_property
    def absorbed(self) -> Places:
        """Missing effects that the simulator's own numbers can absorb on these shots."""
        told = self.evidence.decidable(self.evidence.free, self.settings.min_sample_size)
        return tuple(k for k in self.candidates if not (self.evidence.listed[k] or k in told))

    @cached_property
    def handicaps(self) -> Floats:
        """(K,) what hypotheses must gain beyond the simulator's own numbers to go before them."""
        handicaps = np.where(self.evidence.listed, 0.0, self.settings.listed_advantage)
        handicaps[list(self.absorbed)] = self.tolerance
        return handicaps

    def best(self, required: Places, excluded: Iterable[int], most: int) -> Places:
        """Return the explanation of the largest penalised score, by beam search.

        Args:
            required: hypotheses that are part of it.
            excluded: hypotheses that are not.
            most: hypotheses that it may have.
        """
        excluded = {*required, *excluded}
        free = [k for k in self.candidates if k not in excluded]
        return self.search.best(required, free, most)

    @cached_property
    def search(self) -> SetSearch:
        """Over sets of hypotheses."""
        return SetSearch(self.set_scores, self.penalty, self.handicaps)

    def gain(self, causes: Places) -> float:
        """Return what a set of hypotheses gains in twice the log likelihood."""
        return self.search.gain(causes)

    def given(self, k: int, causes: Places) -> Places:
        """Return what is free when a hypothesis is tested beside the causes.

        A missing effect must stand beside the simulator's own numbers, unless they can absorb it
        whatever its size; one of these beside the causes alone, since a wrong number is a simpler
        cause than two.
        """
        alone = self.evidence.listed[k] or k in self.absorbed
        own = () if alone else self.evidence.free
        return tuple(sorted({*own, *causes} - {k}))

    def tests(self, causes: Places) -> dict[int, ScoreTest]:
        """Return the tests of all candidates, each beside the causes."""
        score_test = {
            k: self.evidence.score_test([k], self.given(k, causes)) for k in self.candidates
        }
        decided = {k: one for k, one in score_test.items() if self._decides(k, one)}
        return decided

    def _decides(self, k: int, test: ScoreTest) -> bool:
        return self.evidence.decides(test, self.settings.min_sample_size) or bool(
            self.evidence.listed[k]
        )

    def alternatives(self, k: int, causes: Places) -> Places:
        """Return the class of a cause: the hypotheses that in its place explain about as much.

        Where the simulator's own numbers can absorb it, those that do so together are among them.
        """
        others = tuple(one for one in causes if one != k)
        observable = [
            one for one in np.flatnonzero(self.evidence.observable).tolist() if one not in causes
        ]
        if not observable:
            return (k,)
        sets = np.array([(*others, one) for one in observable])
        gains, _ = self.set_scores.gains(sets)
        close = gains > self.gain(causes) - self.tolerance
        single = (one for one, near in zip(observable, close, strict=True) if near)
        return (k, *dict.fromkeys((*single, *self._together(k, causes))))

    def _together(self, k: int, causes: Places) -> Places:
        """Return the simulator's own numbers that together explain about as much as one cause."""
        if k not in self.absorbed:
            return ()
        others = tuple(one for one in causes if one != k)
        missing = np.flatnonzero(~self.evidence.listed).tolist()
        found = self.best(others, missing, len(others) + self.settings.growth)
        near = self.gain(found) > self.gain(causes) - self.tolerance
        return tuple(one for one in found if one not in others) if near else ()


@dataclass(frozen=True)
class Explanation:
    """A set of causes, each with the chance that the largest of all is as large by chance.

    It is 1 for known causes of which the shots decide nothing any more.
    """

    causes: Places
    p_values: dict[int, float]


def best_explanation(
    explainer: Explainer, required: Places = (), most: int | None = None
) -> Explanation:
    """Return the best explanation all of whose causes are significant and hold on other shots.

    Args:
        explainer: weighs them.
        required: causes that are known.
        most: causes that it may have, if not those of one round.
    """
    most = explainer.settings.growth if most is None else most
    level = explainer.evidence.settings.level
    excluded: set[int] = set()
    while True:
        causes = explainer.best(required, excluded, most)
        tests = explainer.tests(causes)
        p_values = (
            dict(zip(tests, familywise_p_values(list(tests.values())), strict=True))
            if tests
            else {}
        )
        p_values |= {k: 1.0 for k in causes if k in tests and tests[k].held_out_gain <= 0.0}
        weak = [k for k in causes if k not in required and p_values.get(k, 1.0) > level]
        if not weak:
            return Explanation(causes, {k: float(p_values.get(k, 1.0)) for k in causes})
        excluded.add(max(weak, key=lambda k: p_values.get(k, 1.0)))
