"""Scores of sets of hypotheses, by the thousand, and a beam search for the best set.

All is linear about one fit. What a set gains with one more hypothesis follows from the set by a
block update, for all further hypotheses of all sets at once.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from rallygap.models.ball.simulator import Simulator
from rallygap.models.ball.types import Floats
from rallygap.models.gap.inference.score_test import Evidence
from rallygap.models.gap.settings import GapSettings
from rallygap.models.gap.types import Bools, Indices, Places

LEAST_LEFT = 1e-12  # of a hypothesis's information given others, against rounding
RIDGE = 1e-9  # of the information, so that sets of exactly collinear hypotheses have a score
NOTHING = 1e-300  # information of a hypothesis of which the shots tell nothing: it gains nothing


@dataclass(frozen=True)
class SetScores:
    """Scores sets of K hypotheses.

    Attributes:
        information: (K, K) of all shots.
        scores: (K,) of all shots.
        start: (K,) values from which estimates depart.
        bounds: (K, 2) of the values.
        refitted: (K,) whether the shots were refitted with it; such hypotheses may be collinear.
    """

    information: Floats
    scores: Floats
    start: Floats
    bounds: Floats
    refitted: Bools
    settings: GapSettings

    @classmethod
    def of(cls, evidence: Evidence, nominal: Simulator, refitted: Sequence[int]) -> "SetScores":
        """Return the scores of departures from the nominal simulator."""
        return cls(
            information=_with_ridge(evidence.total),
            scores=evidence.scores.sum(axis=0),
            start=np.array([column.value(nominal) for column in evidence.columns]),
            bounds=np.array([column.declaration.bounds for column in evidence.columns]),
            refitted=np.isin(np.arange(len(evidence.columns)), refitted),
            settings=evidence.settings,
        )

    def with_total(self, information: Floats, scores: Floats) -> "SetScores":
        """Return the scores by another (K, K) information and other (K,) scores of all shots."""
        return replace(self, information=_with_ridge(information), scores=scores)

    def gain(self, places: Places) -> float:
        """Return what one set gains in twice the log likelihood."""
        return float(self.gains(np.array([places]))[0][0]) if places else 0.0

    def gains(self, sets: Indices) -> tuple[Floats, Floats]:
        """Return the (R,) gains of (R, S) sets of hypotheses, and their (R, S) estimates.

        Sets with implausible values, or values that are not identifiable, gain minus infinity.
        """
        inverse = self._inverse(sets)
        estimates = (inverse @ self.scores[sets][..., None])[..., 0]
        variance = np.einsum("rii->ri", inverse)
        possible = self._possible(sets, estimates, variance).all(axis=1)
        return np.where(possible, (estimates * self.scores[sets]).sum(axis=1), -np.inf), estimates

    def gains_with_one_more(self, sets: Indices, further: Sequence[int]) -> Floats:
        """Return the (R, F) gains of (R, S) sets, each with one of F further hypotheses.

        Those that a set has already gain minus infinity.
        """
        more, inverse = np.array(further, dtype=np.int64), self._inverse(sets)
        estimates = (inverse @ self.scores[sets][..., None])[..., 0]
        across = self.information[sets[:, :, None], more]
        swept = inverse @ across
        left = np.diag(self.information)[more] - (across * swept).sum(axis=1)
        member = (sets[:, :, None] == more).any(axis=1)
        left = np.maximum(left, LEAST_LEFT * np.diag(self.information)[more])
        score = self.scores[more] - (estimates[..., None] * across).sum(axis=1)
        step = score / left
        values = estimates[..., None] - swept * step[:, None]
        variances = np.einsum("rii->ri", inverse)[..., None] + swept**2 / left[:, None]
        possible = self._possible(sets[..., None], values, variances).all(axis=1)
        possible &= self._possible(more, step, 1 / left)
        gains = (estimates * self.scores[sets]).sum(axis=1)[:, None] + score * step
        return np.where(possible & ~member, gains, -np.inf)

    def best(
        self,
        required: Places,
        candidates: Sequence[int],
        most: int,
        penalty: float,
        handicaps: Floats,
    ) -> Places:
        """Return the set of at most ``most`` members with the largest penalised score.

        The score is the gain less, for each further member, the penalty and its (K,) handicap.
        """
        beam, best = np.array([required], dtype=np.int64), required
        top = self.gain(required) - handicaps[list(required)].sum()
        for size in range(len(required) + 1, min(most, len(required) + len(candidates)) + 1):
            beam, leader = self._extended(beam, candidates, handicaps)
            leader -= penalty * (size - len(required))
            if leader > top:
                best, top = tuple(beam[0].tolist()), leader
        return best

    def _extended(
        self, beam: Indices, candidates: Sequence[int], handicaps: Floats
    ) -> tuple[Indices, float]:
        """Return the best sets of one more member, best first, and the first's score."""
        handicap = handicaps[beam].sum(axis=1)[:, None] + handicaps[candidates]
        gains = self.gains_with_one_more(beam, candidates) - handicap
        order = np.argsort(-gains, axis=None, kind="stable")
        parents, further = np.unravel_index(order, gains.shape)
        sets = np.sort(np.column_stack([beam[parents], np.array(candidates)[further]]), axis=1)
        sets = sets[(np.diff(sets, axis=1) > 0).all(axis=1)]
        settings = self.settings.inference
        width = min(settings.beam_width, max(settings.beam_work // sets.shape[1], 1))
        sets = sets[: width * sets.shape[1]]  # a set has as many parents as members, at most
        _, first = np.unique(sets, axis=0, return_index=True)
        return sets[np.sort(first)[:width]], float(gains.flat[order[0]])

    def _inverse(self, sets: Indices) -> Floats:
        inverse = np.linalg.inv(self.information[sets[:, :, None], sets[:, None, :]])
        return np.asarray(inverse, dtype=np.float64)

    def _possible(self, places: Indices, estimates: Floats, variance: Floats) -> Bools:
        """Return which estimates are within bounds, and not collinear with the others."""
        settings, variance = self.settings.inference, np.maximum(variance, 0.0)
        value = self.start[places] + estimates
        error = settings.bound_tolerance * np.sqrt(variance)
        low, high = self.bounds[places, 0] - error, self.bounds[places, 1] + error
        inflation = variance * np.diag(self.information)[places]
        identified = (inflation < settings.max_variance_inflation) | self.refitted[places]
        possible: Bools = (value > low) & (value < high) & identified
        return possible


def _with_ridge(information: Floats) -> Floats:
    """Return information of which all sets of hypotheses have a score."""
    known = np.maximum(RIDGE * np.diag(information), NOTHING)
    ridged: Floats = information + np.diag(known)
    return ridged
