"""The log of many points: what changed the balls, and how the points ended."""

from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from models.arena.contacts import KINDS, Touches

Floats = NDArray[np.float64]
Integers = NDArray[np.int64]


@dataclass
class Log:
    """What happened in N points, noted in any order.

    Attributes:
        events: point (n,), time (n,), kind (n,) and state (n, 9) of what changed a ball.
        strokes: (N,) racket contacts.
        winner: (N,) number of the side.
        ended_by: (N,) as in ``recording.Point``.
        end: (N,) s after the launch.
        gone: (N,) s after the launch at which the ball was last seen.
    """

    strokes: Integers
    winner: Integers
    ended_by: NDArray[np.str_]
    end: Floats
    gone: Floats
    events: list[tuple[Integers, Floats, NDArray[np.str_], Floats]] = field(default_factory=list)

    @classmethod
    def of(cls, count: int) -> "Log":
        """Return an empty log of ``count`` points."""
        zeros = np.zeros(count, dtype=np.int64)
        seconds = np.zeros(count)
        unknown = np.full(count, "", dtype="<U13")
        return cls(zeros, zeros.copy(), unknown, seconds, seconds.copy())

    def note(self, points: Integers, times: Floats, kind: str, states: Floats) -> None:
        """Note one event in each of some points."""
        self.events.append((points, times, np.full(len(points), kind, dtype="<U6"), states))

    def note_touches(
        self, points: Integers, starts: Floats, flight: Touches, until: Floats
    ) -> None:
        """Note what balls touched up to a time after their strokes at ``starts``."""
        for k in range(flight.times.shape[1]):
            for surface, kind in KINDS.items():
                noted = (flight.surfaces[:, k] == surface) & (flight.times[:, k] < until)
                times = (starts + flight.times[:, k])[noted]
                self.note(points[noted], times, kind, flight.states[noted, k])

    def decide(
        self,
        points: Integers,
        winner: Integers,
        ended_by: NDArray[np.str_],
        end: Floats,
        gone: Floats,
    ) -> None:
        """Note how some points ended."""
        self.winner[points], self.ended_by[points] = winner, ended_by
        self.end[points], self.gone[points] = end, gone
