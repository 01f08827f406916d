"""How a reader took what was put before it, counted."""

from collections import Counter
from collections.abc import Iterable
from dataclasses import dataclass


@dataclass(frozen=True)
class Counts:
    """How often each outcome came.

    Attributes:
        reader: its name.
        inputs: all.
        refused: as a whole, by one clear error.
        in_part: rows were refused, and counted.
        accepted: taken as they are.
        faults: anything else.
    """

    reader: str
    inputs: int
    refused: int
    in_part: int
    accepted: int
    faults: int


def counted(reader: str, outcomes: Iterable[str]) -> Counts:
    """Count outcomes."""
    found = Counter(outcomes)
    return Counts(
        reader,
        found.total(),
        found["refused"],
        found["in_part"],
        found["accepted"],
        found["fault"],
    )
