"""Scales: what sets of hypotheses gain, by the thousand, and which values make physical sense.

All is linear about one fit. What a set gains with one more hypothesis follows from the set by a
block update, for all further hypotheses of all sets at once, so that long sets cost little more
than short ones.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from models.ball.simulator import Simulator
from models.ball.types import Floats
from models.gap.inference.score_test import Evidence
from models.gap.settings import GapSettings
from models.gap.types import Bools, Indices

LEAST_LEFT = 1e-12  # of a hypothesis's information beside others, against rounding
RIDGE = 1e-9  # of the information, so that sets of exactly alike hypotheses can be weighed
NOTHING = 1e-300  # information of a hypothesis of which the shots tell nothing: it gains nothing


@dataclass(frozen=True)
class SetScores:
    """What weighs sets of K hypotheses.

    Attributes:
        information: (K, K) of all shots.
        scores: (K,) of all shots.
        start: (K,) values from which estimates depart.
        bounds: (K, 2) of the values.
        refitted: (K,) whether the shots were refitted with it, by which those of them that look
            much alike are told apart: a lift that saturates from a weaker one that does not.
    """

    information: Floats
    scores: Floats
    start: Floats
    bounds: Floats
    refitted: Bools
    settings: GapSettings

    @classmethod
    def of(cls, evidence: Evidence, nominal: Simulator, refitted: Sequence[int]) -> "SetScores":
        """Return the scales for departures from the nominal simulator.

        Args:
            evidence: about them.
            nominal: the simulator.
            refitted: hypotheses that the shots were refitted with.
        """
        known = np.maximum(RIDGE * np.diag(evidence.total), NOTHING)
        information = evidence.total + np.diag(known)
        start = [one.value(nominal) for one in evidence.columns]
        bounds = [one.declaration.bounds for one in evidence.columns]
        scores = evidence.scores.sum(axis=0)
        with_it = np.isin(np.arange(len(start)), refitted)
        return cls(
            information, scores, np.array(start), np.array(bounds), with_it, evidence.settings
        )

    def gains(self, sets: Indices) -> tuple[Floats, Floats]:
        """Return the (R,) gains of (R, S) sets of hypotheses, and their (R, S) estimates.

        Sets whose values make no sense, or are not told apart, gain minus infinity.
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
