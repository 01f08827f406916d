"""The paper's numbers and claims, a row each, and where ours come from (``values.csv``)."""

import csv
from collections.abc import Mapping
from functools import cache
from pathlib import Path
from typing import Annotated, Any, NamedTuple

from pydantic import Field, TypeAdapter
from pydantic.dataclasses import dataclass

NOTHING = "–"
PATH = Path(__file__).with_name("values.csv")


@dataclass(frozen=True)
class Value:
    """A number or claim of the paper.

    Attributes:
        group: of values that are shown together.
        id: unique among values.
        what: it is, or is claimed.
        stage: that makes our number; empty where none does.
        rule: by which ours is assessed. ``same`` and ``at_least``: a setting; ``rate``: a count of
            shots; ``more`` and ``less``: the sign of a change; ``twice``: a ratio;
            ``every_horizon``: a claim about all horizons; ``quoted``: not measured here.
        value: the paper's; ``None`` where it is only drawn or described.
        shown: how the paper describes it.
        unit: of the numbers.
        count: of shots that the paper prints.
        of: so many shots.
        source: kind of ``ours``, a key of ``sources.READERS``.
        ours: where our number is: a file or a parameter, and what in it.
        argument: what the source needs besides.
        minus: argument of the number that is taken off.
        ends: columns with the ends of the interval and, of a rate, with the count and of how many.
        offset: added to our number, which is then multiplied by ``scale``.
        scale: see there.
    """

    group: str
    id: str
    what: str
    stage: str = ""
    rule: str = "same"
    value: Annotated[float | str | None, Field(union_mode="left_to_right")] = None
    shown: str = ""
    unit: str = ""
    count: int | None = None
    of: int | None = None
    source: str = "nothing"
    ours: str = ""
    argument: str = ""
    minus: str = ""
    ends: str = ""
    offset: float = 0
    scale: float = 1

    @property
    def printed(self) -> float | str | None:
        """The paper's value; ``None`` where it is described in words or drawn."""
        if self.count is not None and self.of is not None:
            return 100 * self.count / self.of
        return self.value

    @property
    def printed_text(self) -> str:
        """The paper's value as text."""
        if self.count is not None:
            return f"{self.count} of {self.of}: {with_unit(self.printed, '%')}"
        return self.shown or with_unit(self.value, self.unit)


class PrintedTransfer(NamedTuple):
    """A set of the paper's Table I: its shots, and ``counts[horizons][predictor][outcome]``."""

    shots: int
    counts: Mapping[str, Mapping[str, Mapping[str, int]]]


@cache
def printed_values() -> tuple[Value, ...]:
    """Return all values in the paper's order."""
    with PATH.open(encoding="utf-8", newline="") as file:
        rows = ({name: text for name, text in row.items() if text} for row in csv.DictReader(file))
        return tuple(TypeAdapter(Value).validate_python(row) for row in rows)


def printed_transfer() -> dict[str, PrintedTransfer]:
    """Return the paper's Table I by set."""
    printed: dict[str, PrintedTransfer] = {}
    for value in printed_values():
        if value.group == "transfer" and "first_window" not in value.id:
            _, name, horizons, predictor, outcome = value.id.split(".")
            counts: Any = printed.setdefault(name, PrintedTransfer(value.of or 0, {})).counts
            counts.setdefault(horizons, {}).setdefault(predictor, {})[outcome] = value.count
    return printed


def number_or_text(text: str) -> float | str:
    """Return a number where a text is one."""
    try:
        return float(text)
    except ValueError:
        return text


def number(value: float) -> str:
    """Return a number with three digits, however small it is."""
    return f"{value:,.0f}" if abs(value) >= 1000 else f"{value:.3g}"


def with_unit(value: float | str | None, unit: str) -> str:
    """Return a value as text; a dash for none."""
    if value is None:
        return NOTHING
    return value if isinstance(value, str) else f"{number(value)} {unit}".strip()
