"""Log of the ball contacts and outcomes of many points."""

from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from models.arena.contacts import KINDS, ContactSequence

Floats = NDArray[np.float64]
Integers = NDArray[np.int64]


@dataclass
class EventLog:
    """Events and outcomes of N points, in any order.

    Attributes:
        events: point (n,), time (n,), kind (n,) and state just after (n, 9) of contacts.
        strokes: (N,) racket contacts.
        winner: (N,) index of the side.
        ended_by: (N,) as in ``recording.Point``.
        end: (N,) s after the launch.
        last_visible: (N,) s after the launch of the last sample.
    """

    strokes: Integers
    winner: Integers
    ended_by: NDArray[np.str_]
    end: Floats
    last_visible: Floats
    events: list[tuple[Integers, Floats, NDArray[np.str_], Floats]] = field(default_factory=list)

    @classmethod
    def empty(cls, count: int) -> "EventLog":
        """Return an empty log of ``count`` points."""
        zeros = np.zeros(count, dtype=np.int64)
        seconds = np.zeros(count)
        unknown = np.full(count, "", dtype="<U13")
        return cls(zeros, zeros.copy(), unknown, seconds, seconds.copy())

    def add(self, points: Integers, times: Floats, kind: str, states: Floats) -> None:
        """Add one event to each of some points."""
        self.events.append((points, times, np.full(len(points), kind, dtype="<U6"), states))

    def add_contacts(
        self, points: Integers, starts: Floats, flight: ContactSequence, until: Floats
    ) -> None:
        """Add the contacts up to a time ``until`` after the strokes at ``starts``."""
        for k in range(flight.times.shape[1]):
            for surface, kind in KINDS.items():
                noted = (flight.surfaces[:, k] == surface) & (flight.times[:, k] < until)
                times = (starts + flight.times[:, k])[noted]
                self.add(points[noted], times, kind, flight.states[noted, k])

    def set_outcomes(
        self,
        points: Integers,
        winner: Integers,
        ended_by: NDArray[np.str_],
        end: Floats,
        last_visible: Floats,
    ) -> None:
        """Set winner and end of some points."""
        self.winner[points], self.ended_by[points] = winner, ended_by
        self.end[points], self.last_visible[points] = end, last_visible
