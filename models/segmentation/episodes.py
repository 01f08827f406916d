"""Episodes: one ball from a racket contact, or a launch, to the next or to the rally's end."""

from collections.abc import Iterator
from dataclasses import dataclass, field
from typing import Literal

from models.segmentation.contacts import Contact
from models.segmentation.cuts import Cuts

Start = Literal["launch", "racket", "gap", "recording"]
End = Literal["racket", "gap", "recording", "rally_end"]


@dataclass
class Episode:
    """The flights that one stroke or launch sets off.

    Attributes:
        starts_with: what begins it.
        flights: the numbers of its flights, one after the other.
        contacts: those that begin it, lie inside it, or end the rally.
        ends_with: what ends it.
        ended_by: the contact that ends it; ``None`` where the samples end.
    """

    starts_with: Start
    flights: list[int]
    contacts: list[Contact] = field(default_factory=list)
    ends_with: End = "recording"
    ended_by: Contact | None = None

    @property
    def begun_by(self) -> Contact | None:
        """The racket contact that begins it; ``None`` where the samples begin."""
        return self.contacts[0] if self.starts_with == "racket" else None

    def is_over_with(self, contact: Contact) -> bool:
        """Whether the rally ends with ``contact``: on the floor, or twice on one side."""
        if contact.kind == "floor":
            return True
        bounces = [earlier for earlier in self.contacts if earlier.kind == "table"]
        if contact.kind != "table" or not bounces:
            return False
        return bool(bounces[-1].position[1] * contact.position[1] > 0)


def episodes(cuts: Cuts, first: Start) -> Iterator[Episode]:
    """Join flights to episodes.

    After a rally's end the ball is nobody's until a racket meets it or a gap hides it.

    Args:
        cuts: a recording's flights and contacts.
        first: what begins the recording, ``launch`` or ``recording``.
    """
    current: Episode | None = None
    for flight in range(cuts.flights):
        contact = cuts.contacts.get(flight)
        if contact is None:
            yield from _ended(current, "gap")
            current = Episode(first if flight == 0 else "gap", [flight])
        elif contact.kind == "racket":
            yield from _ended(current, "racket", contact)
            current = Episode("racket", [flight], [contact])
        elif current and current.is_over_with(contact):
            current.contacts.append(contact)
            yield from _ended(current, "rally_end", contact)
            current = None
        elif current:
            current.contacts.append(contact)
            current.flights.append(flight)
    yield from _ended(current, "recording")


def _ended(episode: Episode | None, with_: End, by: Contact | None = None) -> Iterator[Episode]:
    if episode:
        episode.ends_with, episode.ended_by = with_, by
        yield episode
