"""Phase test: the omnibus terms of one phase, given the whole catalogue, together and each alone.

The catalogue's parameters may be collinear, so the projection uses a pseudo-inverse.
"""

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from scipy.stats import chi2

from rallygap.models.ball.types import Floats
from rallygap.models.gap.fit.projection import Projection, identifiable_directions
from rallygap.models.gap.inference.score_test import Evidence, ScoreTest
from rallygap.models.gap.locate.terms import Term


@dataclass(frozen=True)
class PhaseTest:
    """The D terms of a phase that are seen, given N parameters of the catalogue.

    Attributes:
        evidence: for hypotheses and terms.
        phase: of the terms.
        withheld: effects that are not in the catalogue.
    """

    evidence: Evidence
    phase: str
    withheld: tuple[str, ...]

    @cached_property
    def places(self) -> list[int]:
        """(D,) places of the terms."""
        columns = self.evidence.columns
        return [k for k in self._seen if columns[k].effect == self.phase]

    @cached_property
    def given(self) -> list[int]:
        """(N,) places of the catalogue's parameters."""
        columns = self.evidence.columns
        effects = [k for k in self._seen if not isinstance(columns[k], Term)]
        return [k for k in effects if columns[k].effect not in self.withheld]

    @cached_property
    def _seen(self) -> list[int]:
        return np.flatnonzero(self.evidence.observable).tolist()

    @cached_property
    def spread(self) -> Floats:
        """(N, N) covariance of the catalogue's values, which may be alike."""
        directions = identifiable_directions(self.evidence.total[np.ix_(self.given, self.given)])
        return directions @ directions.T

    @cached_property
    def projection(self) -> Projection:
        """On the terms, given the catalogue's parameters, by their pseudo-inverse."""
        evidence, spread = self.evidence, self.spread
        values = spread @ evidence.scores[:, self.given].sum(axis=0)
        mixing = evidence.total[np.ix_(self.places, self.given)] @ spread
        return Projection(self.places, self.given, values, mixing)

    @cached_property
    def scores(self) -> Floats:
        """(B, D) scores of the terms, given the catalogue with its values."""
        return self.projection.scores(self.evidence.scores, self.evidence.information)

    @cached_property
    def information(self) -> Floats:
        """(D, D) of the terms, given the catalogue."""
        total = self.evidence.total
        mixed = self.projection.mixing @ total[np.ix_(self.given, self.places)]
        return total[np.ix_(self.places, self.places)] - mixed

    @cached_property
    def directions(self) -> Floats:
        """(D, E) of the terms of which a good part is not in the span of the catalogue.

        Scores along them have unit variance.
        """
        scale = np.sqrt(np.diag(self.evidence.total)[self.places])
        least = self.evidence.settings.name.min_direction_information
        return identifiable_directions(self.information, scale, least)

    @cached_property
    def along(self) -> Floats:
        """(B, E) scores of the shots along the directions."""
        return self.scores @ self.directions

    @property
    def estimate(self) -> Floats:
        """(D,) of the terms."""
        estimate: Floats = self.directions @ self.along.sum(axis=0)
        return estimate

    @cached_property
    def alone(self) -> dict[int, ScoreTest]:
        """Tests of each term of which enough information is left, by number."""
        k, settings = self.places, self.evidence.settings
        shares = self.projection.information_diagonal(self.evidence.information)
        least = settings.name.min_term_information * np.diag(self.evidence.total)[k]
        return {
            d: ScoreTest(
                (k[d],), self.scores[:, [d]], shares[:, [d], None], settings, self.evidence.of_prior
            )
            for d in np.flatnonzero(shares.sum(axis=0) > least).tolist()
        }

    @property
    def clearest(self) -> Floats:
        """(D,) the value of the term with the smallest p-value, others zero."""
        terms = np.zeros(len(self.places))
        number = min(self.alone, key=lambda d: _p_value(self.alone[d]))
        terms[number] = self.alone[number].estimate[0]
        return terms

    @cached_property
    def p_value_alone(self) -> float:
        """The smallest p-value of a term."""
        return min((_p_value(test) for test in self.alone.values()), default=1.0)

    @cached_property
    def squared(self) -> float:
        """Twice the gain of log likelihood."""
        return float((self.along.sum(axis=0) ** 2).sum())

    @property
    def gain(self) -> float:
        """Twice the gain of log likelihood beyond what as many directions of noise gain."""
        return max(self.squared - float(self.along.shape[1]), 0.0)

    @property
    def rarity(self) -> float:
        """Logarithm of the p-value of so much structure, by the noise as estimated."""
        return float(chi2.logsf(self.squared, max(self.along.shape[1], 1)))

    def p_value(self, signs: Floats) -> float:
        """Return the p-value of so much structure, by (R, B) random signs of the shots.

        Shots whose values were fitted spread less than they did: the noise as estimated must agree.
        """
        if self.along.shape[1] == 0:
            return 1.0
        above = int((((signs @ self.along) ** 2).sum(axis=1) >= self.squared).sum())
        by_noise = float(chi2.sf(self.squared, self.along.shape[1]))
        return max((1 + above) / (1 + len(signs)), by_noise)

    def predicted_score(self, terms: Floats, others: Evidence) -> tuple[float, float]:
        """Return how far other shots follow (D,) values of the terms, and its standard error."""
        k, n, mixing = self.places, self.given, self.projection.mixing
        scores = self.projection.scores(others.scores, others.information)
        score = scores.sum(axis=0) @ terms
        across = others.total[np.ix_(k, n)] - mixing @ others.total[np.ix_(n, n)]
        of_terms = self.projection.information(others.total[None])[0]
        # The catalogue's values err, too, as far as they show on the other shots.
        variance = terms @ (of_terms + across @ self.spread @ across.T) @ terms
        return float(score), float(np.sqrt(max(float(variance), 0.0)))


def _p_value(test: ScoreTest) -> float:
    """Return the p-value of a term; the noise as estimated must agree."""
    return max(test.p_value, float(chi2.sf(test.gain, 1)))
