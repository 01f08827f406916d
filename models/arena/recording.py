"""Recordings of the arena: camera samples, the umpire's record and the sealed truth."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]


@dataclass(frozen=True)
class TrueContacts:
    """Launches and contacts of a ball, in order of time.

    Attributes:
        times: (k,) s on the recording's clock.
        kinds: (k,) ``launch`` (out of the cannon, or from the palm that tosses it), ``racket``,
            ``table``, ``net`` or ``floor``.
        states: (k, 9) just after.
    """

    times: Floats
    kinds: NDArray[np.str_]
    states: Floats


@dataclass(frozen=True)
class Point:
    """The umpire's record of a point; ``near`` is the player at y < 0.

    Attributes:
        start: when the ball leaves the server's palm (s).
        end: when the point is decided (s).
        server: ``near`` or ``far``.
        winner: ``near`` or ``far``.
        ended_by: ``net``, ``out``, ``double_bounce`` or ``missed``.
        strokes: racket contacts, the serve included.
    """

    start: float
    end: float
    server: str
    winner: str
    ended_by: str
    strokes: int


@dataclass(frozen=True)
class ArenaRecording:
    """One shot of the cannon, or a few points of a match.

    Attributes:
        name: ``<group>/<number>``.
        times: (n,) s.
        positions: (n, 3) measured, m.
        spins: (n, 3) measured, rad/s.
        contacts: the true contacts (sealed).
        points: the umpire's record, empty for the cannon.
    """

    name: str
    times: Floats
    positions: Floats
    spins: Floats
    contacts: TrueContacts
    points: tuple[Point, ...] = ()
