"""Supply: balls made in batches, handed out one after the other."""

import numpy as np
from numpy.typing import NDArray

from models.policy.batch_simulation import Court
from models.policy.incoming_balls import Balls

BATCH = 256  # balls made at once, so that a new episode costs next to nothing


class Supply:
    """The balls that come of one random generator, for the arms of a court.

    Attributes:
        numbers: (B,) of the balls that the arms have, counted from zero.
    """

    def __init__(self, balls: Balls, arms: int, random: np.random.Generator) -> None:
        """Make the first batch, for ``arms`` (B) arms."""
        self.numbers = np.zeros(arms, dtype=np.int64)
        self._balls, self._random = balls, random
        self._size = max(BATCH, arms)
        self._handed_out = 0
        self._fill()

    def serve(self, court: Court, which: NDArray[np.bool_]) -> None:
        """Begin new episodes for the arms of ``which`` (B,)."""
        waiting = np.flatnonzero(which)
        while len(waiting):
            if self._next == self._size:
                self._fill()
            served = waiting[: self._size - self._next]
            self._hand_out(court, served)
            waiting = waiting[len(served) :]

    def _fill(self) -> None:
        self._incoming, self._goals = self._balls(self._size, self._random)
        self._next = 0

    def _hand_out(self, court: Court, arms: NDArray[np.int64]) -> None:
        rows = slice(self._next, self._next + len(arms))
        which = np.zeros(len(self.numbers), dtype=np.bool_)
        which[arms] = True
        court.reset(which, self._incoming[rows], self._goals[rows])
        self.numbers[arms] = self._handed_out + np.arange(len(arms))
        self._handed_out += len(arms)
        self._next += len(arms)
