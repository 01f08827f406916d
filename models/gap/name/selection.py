"""Selection: the fewest hypotheses that explain the shots, and their alternatives (docs/naming.md).

The penalised score of a set of k hypotheses is ``2 dlog L - lambda k``, with lambda the squared
critical value of the largest of all candidates at the level asked for (the risk inflation
criterion, Foster and George 1994). All is linear about one fit.
"""

from collections.abc import Iterable
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from rallygap.models.ball.simulator import Simulator
from rallygap.models.ball.types import Floats
from rallygap.models.gap.fit.refit import RefitResult
from rallygap.models.gap.inference.score_test import Evidence, ScoreTest, familywise_p_values
from rallygap.models.gap.inference.set_scores import SetScores
from rallygap.models.gap.settings import NameSettings, Question
from rallygap.models.gap.types import Places


def evidence_about(fit: RefitResult, question: Question) -> Evidence:
    """Return the evidence of refitted shots about departures from the nominal simulator."""
    evidence = Evidence.of(fit.linear, fit.noise_estimate, question.settings)
    nominal, withheld = question.simulator, question.withheld
    kept = [k for k, column in enumerate(evidence.columns) if column.effect not in withheld]
    columns = tuple(evidence.columns[k] for k in kept)
    information = evidence.information[:, kept][:, :, kept]
    scores = evidence.scores[:, kept] + information @ fit.linear.departures(nominal)[kept]
    listed = np.array([column.listed(nominal) for column in columns], dtype=bool)
    return replace(evidence, columns=columns, listed=listed, scores=scores, information=information)


@dataclass(frozen=True)
class Explainer:
    """Scores explanations.

    Attributes:
        evidence: about departures from the nominal simulator.
        nominal: the simulator.
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
        """Scores of sets of hypotheses."""
        return SetScores.of(self.evidence, self.nominal, self.refitted)

    @cached_property
    def candidates(self) -> Places:
        """Hypotheses that these shots could show if nothing else were wrong."""
        return self.evidence.decidable((), self.settings.min_sample_size)

    @cached_property
    def penalty(self) -> float:
        """What a member of a set must gain in twice the log likelihood."""
        return self.evidence.settings.penalty(len(self.candidates))

    @property
    def tolerance(self) -> float:
        """Difference of gains up to which two sets explain the shots about as well.

        The true cause is missing among the alternatives with at most the probability ``level``.
        """
        return self.evidence.settings.tolerance

    @cached_property
    def absorbed(self) -> Places:
        """Missing effects that the listed parameters can absorb on these shots."""
        separable = self.evidence.decidable(self.evidence.free, self.settings.min_sample_size)
        return tuple(k for k in self.candidates if not (self.evidence.listed[k] or k in separable))

    @cached_property
    def handicaps(self) -> Floats:
        """(K,) what a missing effect must gain beyond listed parameters to be preferred."""
        handicaps = np.where(self.evidence.listed, 0.0, self.settings.listed_advantage)
        handicaps[list(self.absorbed)] = self.tolerance
        return handicaps

    def best(self, required: Places, excluded: Iterable[int], most: int) -> Places:
        """Return the explanation of the largest penalised score, by beam search."""
        excluded = {*required, *excluded}
        free = [k for k in self.candidates if k not in excluded]
        return self.set_scores.best(required, free, most, self.penalty, self.handicaps)

    def gain(self, causes: Places) -> float:
        """Return what a set of hypotheses gains in twice the log likelihood."""
        return self.set_scores.gain(causes)

    def tests(self, causes: Places) -> dict[int, ScoreTest]:
        """Return the tests of all candidates that the shots decide, each given the causes.

        The listed parameters are free as well when a missing effect is tested, unless they can
        absorb it whatever its size. They are not when one of them is tested: a wrong value is a
        simpler cause than two.
        """
        found = {}
        for k in self.candidates:
            listed = bool(self.evidence.listed[k])
            free = () if listed or k in self.absorbed else self.evidence.free
            test = self.evidence.score_test([k], sorted({*free, *causes} - {k}))
            if listed or self.evidence.decides(test, self.settings.min_sample_size):
                found[k] = test
        return found

    def alternatives(self, k: int, causes: Places) -> Places:
        """Return the class of a cause: the hypotheses that in its place explain about as much.

        Where the listed parameters can absorb it, those that do so together are among them.
        """
        others = tuple(j for j in causes if j != k)
        observable = [
            j for j in np.flatnonzero(self.evidence.observable).tolist() if j not in causes
        ]
        if not observable:
            return (k,)
        gains, _ = self.set_scores.gains(np.array([(*others, j) for j in observable]))
        close = gains > self.gain(causes) - self.tolerance
        single = (j for j, near in zip(observable, close, strict=True) if near)
        return (k, *dict.fromkeys((*single, *self._together(k, causes))))

    def _together(self, k: int, causes: Places) -> Places:
        """Return the listed parameters that together explain about as much as one cause."""
        if k not in self.absorbed:
            return ()
        others = tuple(j for j in causes if j != k)
        missing = np.flatnonzero(~self.evidence.listed).tolist()
        found = self.best(others, missing, len(others) + self.settings.growth)
        near = self.gain(found) > self.gain(causes) - self.tolerance
        return tuple(j for j in found if j not in others) if near else ()


@dataclass(frozen=True)
class Explanation:
    """A set of causes, each with its family-wise p-value.

    It is 1 for known causes of which the shots decide nothing any more.
    """

    causes: Places
    p_values: dict[int, float]


def best_explanation(
    explainer: Explainer, required: Places = (), most: int | None = None
) -> Explanation:
    """Return the best explanation all of whose causes are significant and hold on other shots."""
    most = explainer.settings.growth if most is None else most
    excluded: set[int] = set()
    while True:
        causes = explainer.best(required, excluded, most)
        tests = explainer.tests(causes)
        p_values = dict(zip(tests, familywise_p_values(list(tests.values())), strict=True))
        p_values |= {k: 1.0 for k in causes if k in tests and tests[k].held_out_gain <= 0.0}
        of_causes = {k: float(p_values.get(k, 1.0)) for k in causes}
        level = explainer.evidence.settings.level
        weak = [k for k in causes if k not in required and of_causes[k] > level]
        if not weak:
            return Explanation(causes, of_causes)
        excluded.add(max(weak, key=of_causes.__getitem__))
