"""Episodes: from a racket contact or a launch to the next racket contact or the rally's end."""

from collections.abc import Iterator
from dataclasses import dataclass, field
from typing import Literal

from rallygap.models.segmentation.contacts import Contact
from rallygap.models.segmentation.cuts import Cuts

Start = Literal["launch", "racket", "gap", "recording"]
End = Literal["racket", "gap", "recording", "rally_end"]


@dataclass
class Episode:
    """The flights after one stroke or launch."""

    starts_with: Start  # the event at the start
    flights: list[int]  # the numbers of its flights, one after the other
    # at its start, inside it, or at the end of the rally
    contacts: list[Contact] = field(default_factory=list)
    ends_with: End = "recording"  # the event at the end
    end_contact: Contact | None = None  # the contact at the end; None where the samples end

    def ends_rally(self, contact: Contact) -> bool:
        """Whether ``contact`` ends the rally: the floor, or a second bounce on one side."""
        if contact.kind == "floor":
            return True
        bounces = [earlier for earlier in self.contacts if earlier.kind == "table"]
        if contact.kind != "table" or not bounces:
            return False
        return bool(bounces[-1].position[1] * contact.position[1] > 0)


def episodes(cuts: Cuts, first: Start) -> Iterator[Episode]:
    """Join flights into episodes.

    After the end of a rally the ball is in no episode until the next racket contact or gap.

    Args:
        cuts: a recording's flights and contacts.
        first: the event at the start of the recording, ``launch`` or ``recording``.
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
        elif current and current.ends_rally(contact):
            current.contacts.append(contact)
            yield from _ended(current, "rally_end", contact)
            current = None
        elif current:
            current.contacts.append(contact)
            current.flights.append(flight)
    yield from _ended(current, "recording")


def _ended(episode: Episode | None, with_: End, by: Contact | None = None) -> Iterator[Episode]:
    if episode:
        episode.ends_with, episode.end_contact = with_, by
        yield episode
