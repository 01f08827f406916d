"""Phase selection: which of flight, table and sensor must be wrong to explain the shots.

Effects in different phases may look alike, such as a length scale that reads too short and too
strong a gravity. So each subset of the phases is tried, explained by as few terms (effects of the
catalogue and omnibus terms) as possible, found by stepwise selection. Explanations have the
penalised score ``2 dlog L - lambda k`` and weights ``exp(score / 2)``, as in averaging by an
information criterion (Burnham and Anderson 2002). A term is no cause; a cause has to pass more.
"""

from dataclasses import dataclass, replace
from itertools import combinations

import numpy as np

from models.ball.catalogue import catalogue
from models.ball.types import Floats
from models.gap.fit.linearize import Linearised
from models.gap.fit.refit import RefitResult
from models.gap.hypotheses import Hypothesis
from models.gap.inference.score_test import Evidence
from models.gap.locate.term_library import evidence_with_terms
from models.gap.locate.terms import Term
from models.gap.settings import Question
from models.gap.types import PHASES, Bools, Phase, Places

PHASE_OF: dict[str, Phase] = {"flight": "flight", "contact": "table", "sensor": "sensor"}


@dataclass(frozen=True)
class Candidates:
    """All that may act on shots, in departures from a simulator.

    Attributes:
        linear: the shots, with a column a term.
        evidence: for the terms.
        phases: (K,) in which they act.
        possible: (K,) which of them shots see, withheld ones aside.
    """

    linear: Linearised
    evidence: Evidence
    phases: tuple[Phase, ...]
    possible: Bools

    @classmethod
    def of(cls, fit: RefitResult, question: Question) -> "Candidates":
        """Return the terms about shots that were fitted about a simulator near the nominal one."""
        linear, about = evidence_with_terms(fit, fit.noise_estimate.noise, question.settings)
        scores = about.scores + about.information @ linear.departures(question.simulator)
        allowed = [column.effect not in question.withheld for column in linear.columns]
        return cls(
            linear,
            replace(about, scores=scores),
            tuple(_phase_of(column) for column in linear.columns),
            about.observable & np.array(allowed),
        )

    @property
    def penalty(self) -> float:
        """What a term must gain in twice the log likelihood."""
        return self.evidence.settings.penalty(int(self.possible.sum()))

    def explanations(self) -> dict[Places, float]:
        """Return sets of terms that explain the shots, each with its weight; these sum to one."""
        scores: dict[Places, float] = {(): 0.0}
        for count in range(1, len(PHASES) + 1):
            for some in combinations(PHASES, count):
                terms = self._fewest(self.possible & np.isin(self.phases, some))
                scores[terms] = self._gain(terms) - self.penalty * len(terms)
        values = np.array(list(scores.values()))
        weights = np.exp((values - values.max()) / 2)
        return dict(zip(scores, (weights / weights.sum()).tolist(), strict=True))

    def values(self, terms: Places) -> Floats:
        """Return the values of a set of terms that explain the shots best."""
        inner = self.evidence.total[np.ix_(terms, terms)]
        values: Floats = np.linalg.solve(inner, self.evidence.scores[:, terms].sum(axis=0))
        return values

    def _gain(self, terms: Places) -> float:
        return float(self.values(terms) @ self.evidence.scores[:, terms].sum(axis=0))

    def _fewest(self, usable: Bools) -> Places:
        """Return terms selected one by one, without those that later ones make unnecessary."""
        chosen: Places = ()
        for _ in range(self.evidence.settings.locate.max_terms):
            further = np.where(usable, self._further(chosen), 0.0)
            if further.max() < self.penalty:
                break
            chosen = self._needed((*chosen, int(further.argmax())))
        return tuple(sorted(chosen))

    def _further(self, chosen: Places) -> Floats:
        """Return (K,) what each term would gain given those chosen."""
        total, scores = self.evidence.total, self.evidence.scores.sum(axis=0)
        across, alone = total[list(chosen)], np.diag(total)
        mixed = np.linalg.solve(across[:, list(chosen)], across)
        left = alone - (mixed * across).sum(axis=0)
        score = scores - mixed.T @ scores[list(chosen)]
        enough = left > self.evidence.settings.locate.min_term_information * alone
        further: Floats = np.where(enough, score**2 / np.maximum(left, 1e-300), 0.0)
        return further

    def _needed(self, terms: Places) -> Places:
        """Return the terms without those that gain less than the penalty given the others."""
        while len(terms) > 1:
            inverse = np.linalg.inv(self.evidence.total[np.ix_(terms, terms)])
            losses = self.values(terms) ** 2 / np.diag(inverse)
            if losses.min() >= self.penalty:
                break
            terms = tuple(np.delete(terms, losses.argmin()).tolist())
        return terms


def _phase_of(column: Hypothesis) -> Phase:
    """Return the phase in which an effect of the catalogue, or an omnibus term, acts."""
    if isinstance(column, Term):
        return next(phase for phase in PHASES if phase == column.effect)
    return PHASE_OF[catalogue()[column.effect].acts]
