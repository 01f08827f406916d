"""Phases: which of flight, table and sensor must be wrong so that shots are explained.

Effects in different phases may look alike, such as lengths read too short and too strong a gravity.
So every set of phases is tried, explained by the fewest terms (effects of the catalogue and of the
omnibus basis), each of which must gain more in twice the log likelihood than the largest of all
does by chance. Explanations are weighed by their worth, the gain less this price: where shots tell
the phases apart one of them stays. A term is no name; names have to pass more.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from itertools import combinations

import numpy as np
from scipy.stats import norm

from models.ball.catalogue import catalogue
from models.ball.simulator import Simulator
from models.ball.types import Floats
from models.gap.fit.linearize import Linearised
from models.gap.fit.refit import Refitted
from models.gap.fit.variance_components import Components
from models.gap.hypotheses import Hypothesis
from models.gap.inference.score_test import Evidence
from models.gap.locate.term_library import joined
from models.gap.locate.terms import Term
from models.gap.types import PHASES, Bools, Phase, Places

LEVEL = 0.003  # chance of a term where nothing is wrong
OWN_PART = 1e-3  # of a term's information, that must be left beside those chosen
MOST_TERMS = 12
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
    def of(cls, found: Refitted, nominal: Simulator, withheld: Sequence[str] = ()) -> "Candidates":
        """Return the terms about shots that were fitted about a simulator near the nominal one."""
        linear = joined(found.linear)
        noise = found.components.noise
        known = Components.known(linear, noise, found.components.weights)
        about = Evidence.of(linear, known)
        scores = about.scores + about.information @ moved(linear, nominal)
        allowed = [one.effect not in withheld for one in linear.columns]
        return cls(
            linear,
            replace(about, scores=scores),
            tuple(phase_of(one) for one in linear.columns),
            about.seen & np.array(allowed),
        )

    @property
    def price(self) -> float:
        """What a term must gain to be worth its place."""
        return float(norm.isf(LEVEL / (2 * max(self.possible.sum(), 1))) ** 2)

    def explanations(self) -> dict[Places, float]:
        """Return sets of terms that explain the shots, each with its weight; these sum to one."""
        worth: dict[Places, float] = {(): 0.0}
        for count in range(1, len(PHASES) + 1):
            for some in combinations(PHASES, count):
                terms = self._fewest(self.possible & np.isin(self.phases, some))
                worth[terms] = self._gain(terms) - self.price * len(terms)
        weights = np.exp((np.array(list(worth.values())) - max(worth.values())) / 2)
        return dict(zip(worth, (weights / weights.sum()).tolist(), strict=True))

    def values(self, terms: Places) -> Floats:
        """Return the values of a set of terms that explain the shots best."""
        inner = self.evidence.total[np.ix_(terms, terms)]
        values: Floats = np.linalg.solve(inner, self.evidence.scores[:, terms].sum(axis=0))
        return values

    def _gain(self, terms: Places) -> float:
        return float(self.values(terms) @ self.evidence.scores[:, terms].sum(axis=0))

    def _fewest(self, usable: Bools) -> Places:
        """Return terms found one by one; those that later ones make needless go again."""
        chosen: Places = ()
        for _ in range(MOST_TERMS):
            further = np.where(usable, self._further(chosen), 0.0)
            if further.max() < self.price:
                break
            chosen = self._needed((*chosen, int(further.argmax())))
        return tuple(sorted(chosen))

    def _further(self, chosen: Places) -> Floats:
        """Return (K,) what each term would gain beside those chosen."""
        total, scores = self.evidence.total, self.evidence.scores.sum(axis=0)
        across, own = total[list(chosen)], np.diag(total)
        mixed = np.linalg.solve(across[:, list(chosen)], across)
        left = own - (mixed * across).sum(axis=0)
        score = scores - mixed.T @ scores[list(chosen)]
        further: Floats = np.where(left > OWN_PART * own, score**2 / np.maximum(left, 1e-300), 0.0)
        return further

    def _needed(self, terms: Places) -> Places:
        """Return the terms without those that are not worth their price beside the others."""
        while len(terms) > 1:
            inverse = np.linalg.inv(self.evidence.total[np.ix_(terms, terms)])
            losses = self.values(terms) ** 2 / np.diag(inverse)
            if losses.min() >= self.price:
                break
            terms = tuple(np.delete(terms, losses.argmin()).tolist())
        return terms


def phase_of(one: Hypothesis) -> Phase:
    """Return the phase in which an effect of the catalogue, or a term of the basis, acts."""
    if isinstance(one, Term):
        return next(phase for phase in PHASES if phase == one.effect)
    return PHASE_OF[catalogue()[one.effect].acts]


def moved(linear: Linearised, nominal: Simulator) -> Floats:
    """Return (K,) by how much the simulator of linearised shots departs from the nominal one."""
    return np.array(
        [
            0.0 if isinstance(one, Term) else one.value(linear.simulator) - one.value(nominal)
            for one in linear.columns
        ]
    )
