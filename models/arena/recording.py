"""Recordings of the arena: camera samples, the umpire's record and the sealed truth."""

from collections.abc import Iterable
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from rallygap.models.ball.types import Floats, Integers


class TrueContacts(NamedTuple):
    """Launches and contacts of a ball, in order of time.

    A ``launch`` is out of the cannon, or from the palm that tosses the ball; other kinds are
    ``racket``, ``table``, ``net`` and ``floor``.
    """

    times: Floats  # (k,) s on the recording's clock
    kinds: NDArray[np.str_]  # (k,)
    states: Floats  # (k, 9) just after

    def take(self, rows: Integers | slice) -> "TrueContacts":
        """Return some of the contacts."""
        return TrueContacts(self.times[rows], self.kinds[rows], self.states[rows])

    @classmethod
    def joined(cls, parts: Iterable["TrueContacts"]) -> "TrueContacts":
        """Return the contacts of all parts."""
        return cls(*map(np.concatenate, zip(*parts, strict=True)))


@dataclass(frozen=True)
class Point:
    """The umpire's record of a point; ``near`` is the player at y < 0."""

    start: float  # s, the ball leaves the server's palm
    end: float  # s, the point is decided
    server: str  # near or far
    winner: str  # near or far
    ended_by: str  # net, out, double_bounce or missed
    strokes: int  # racket contacts, the serve included


@dataclass(frozen=True)
class ArenaRecording:
    """One shot of the cannon, or a few points of a match."""

    name: str  # <group>/<number>
    times: Floats  # (n,) s
    positions: Floats  # (n, 3) measured, m
    spins: Floats  # (n, 3) measured, rad/s
    contacts: TrueContacts  # sealed
    points: tuple[Point, ...] = ()  # none of the cannon
