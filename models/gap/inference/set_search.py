"""Beam search for the set of columns with the largest penalised score.

The penalised score of a set of k columns is ``2 dlog L - lambda k``, less a handicap of each.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from models.ball.types import Floats
from models.gap.inference.set_scores import SetScores
from models.gap.types import Indices, Places


@dataclass(frozen=True)
class SetSearch:
    """A search over sets of K columns.

    Attributes:
        set_scores: gains of sets.
        penalty: lambda, what each further column must gain.
        handicaps: (K,) what a column must gain besides.
    """

    set_scores: SetScores
    penalty: float
    handicaps: Floats

    def best(self, required: Places, candidates: Sequence[int], most: int) -> Places:
        """Return the set of the largest penalised score.

        Args:
            required: columns that are part of it.
            candidates: other columns that may be.
            most: columns that it may have.
        """
        beam, best = np.array([required], dtype=np.int64), required
        top = self.gain(required) - self.handicaps[list(required)].sum()
        for size in range(len(required) + 1, min(most, len(required) + len(candidates)) + 1):
            beam, leader = self._extended(beam, candidates)
            leader -= self.penalty * (size - len(required))
            if leader > top:
                best, top = tuple(beam[0].tolist()), leader
        return best

    def gain(self, columns: Places) -> float:
        """Return the gain of one set in twice the log likelihood."""
        return float(self.set_scores.gains(np.array([columns]))[0][0]) if columns else 0.0

    def _extended(self, beam: Indices, candidates: Sequence[int]) -> tuple[Indices, float]:
        """Return the best sets of one more column, best first, and the first's score."""
        handicaps = self.handicaps[beam].sum(axis=1)[:, None] + self.handicaps[candidates]
        gains = self.set_scores.gains_with_one_more(beam, candidates) - handicaps
        order = np.argsort(-gains, axis=None, kind="stable")
        parents, further = np.unravel_index(order, gains.shape)
        sets = np.sort(np.column_stack([beam[parents], np.array(candidates)[further]]), axis=1)
        sets = sets[(np.diff(sets, axis=1) > 0).all(axis=1)]
        settings = self.set_scores.settings.inference
        width = min(settings.beam_width, max(settings.beam_work // sets.shape[1], 1))
        sets = sets[: width * sets.shape[1]]  # a set has as many parents as members, at most
        _, first = np.unique(sets, axis=0, return_index=True)
        return sets[np.sort(first)[:width]], float(gains.flat[order[0]])
