"""Log of the ball contacts and outcomes of many points."""

import numpy as np

from rallygap.models.arena.contacts import KINDS, ContactSequence
from rallygap.models.arena.recording import TrueContacts
from rallygap.models.ball.types import Floats, Integers


class EventLog:
    """Contacts and outcomes of N points, in any order.

    Attributes:
        strokes: (N,) racket contacts.
        winner: (N,) index of the side.
        ended_by: (N,) as in ``recording.Point``.
        end: (N,) s after the launch.
        last_visible: (N,) s after the launch of the last sample.
    """

    def __init__(self, count: int) -> None:
        self.strokes, self.winner = np.zeros((2, count), dtype=np.int64)
        self.end, self.last_visible = np.zeros((2, count))
        self.ended_by = np.full(count, "", dtype="<U13")
        self._points: list[Integers] = []
        self._contacts: list[TrueContacts] = []

    def add(self, points: Integers, times: Floats, kind: str, states: Floats) -> None:
        """Add one contact to each of some points."""
        self._points.append(points)
        kinds = np.full(len(points), kind, dtype="<U6")
        self._contacts.append(TrueContacts(times, kinds, states))

    def add_contacts(
        self, points: Integers, starts: Floats, flight: ContactSequence, until: Floats
    ) -> None:
        """Add the contacts up to a time ``until`` after the strokes at ``starts``."""
        for k in range(flight.times.shape[1]):
            for surface, kind in KINDS.items():
                noted = (flight.surfaces[:, k] == surface) & (flight.times[:, k] < until)
                times = (starts + flight.times[:, k])[noted]
                self.add(points[noted], times, kind, flight.states[noted, k])

    def contacts(self) -> tuple[Integers, TrueContacts]:
        """Return the point of each contact (n,) and the contacts, by point and time."""
        points, contacts = np.concatenate(self._points), TrueContacts.joined(self._contacts)
        order = np.lexsort([contacts.times, points])
        return points[order], contacts.take(order)
