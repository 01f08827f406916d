"""Contacts with the net: the arc before each and the arc after."""

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

from rallygap.models.gap.fit.shots import Shots


@dataclass(frozen=True)
class NetContacts:
    """D contacts with the net.

    Attributes:
        before: (D) arcs that end at the net.
        after: (D) arcs that start there, in the same order.
    """

    before: Shots
    after: Shots

    def __len__(self) -> int:
        return len(self.before)

    def __getitem__(self, index: Any) -> "NetContacts":
        """Return the contacts at ``index``: a slice, an array of numbers or a mask."""
        return self.changed(lambda arcs: arcs[index])

    def changed(self, change: Callable[[Shots], Shots]) -> "NetContacts":
        """Return the contacts with their arcs changed."""
        return NetContacts(change(self.before), change(self.after))
