"""Entries: what the paper shows, and how ours is read from the reports of a run."""

from collections.abc import Callable
from dataclasses import dataclass

from pipeline.paper.judgements import NOT_MEASURED, Interval
from pipeline.paper.run_reports import Reports

NOTHING = "–"


@dataclass(frozen=True)
class Finding:
    """What a run says to an entry.

    Attributes:
        verdict: in a word.
        value: ours; text where it is no number.
        interval: of 95 %, where there is one.
        words: how ours is written, if not as value, interval and unit.
    """

    verdict: str
    value: float | str | None = None
    interval: Interval | None = None
    words: str = ""


MISSING = Finding(NOT_MEASURED)


@dataclass(frozen=True)
class Entry:
    """A figure, table, claim or printed number.

    Attributes:
        key: unique among all.
        what: it says.
        printed: the paper's value; ``None`` where it is told in words or drawn.
        unit: of both values.
        stage: that makes ours.
        where: file and columns of ours, or the parameter.
        find: reads ours.
        words: how the paper's is written, if not as value and unit.
    """

    key: str
    what: str
    printed: float | str | None
    unit: str
    stage: str
    where: str
    find: Callable[[Reports], Finding]
    words: str = ""

    @property
    def paper(self) -> str:
        """The paper's value as text."""
        return self.words or with_unit(self.printed, self.unit)

    def ours(self, found: Finding) -> str:
        """Return our value as text, with its interval."""
        if found.words or found.interval is None:
            return found.words or with_unit(found.value, self.unit)
        value, low, high = map(number, found.interval)
        return f"{value} ({low} to {high}) {self.unit}".strip()


@dataclass(frozen=True)
class Group:
    """Entries that belong together.

    Attributes:
        key: unique among groups.
        title: of the group.
        about: what is compared, and by which rule.
        axis: ends of the scale on which values are drawn; ``None`` where they are only written.
        entries: in the paper's order.
    """

    key: str
    title: str
    about: str
    axis: tuple[float, float] | None
    entries: tuple[Entry, ...]


def number(value: float) -> str:
    """Return a number with three digits, however small it is."""
    return f"{value:,.0f}" if abs(value) >= 1000 else f"{value:.3g}"


def with_unit(value: float | str | None, unit: str) -> str:
    """Return a value and its unit."""
    if value is None:
        return NOTHING
    return value if isinstance(value, str) else f"{number(value)} {unit}".strip()
