"""The comparison: every number and claim of the paper, ours from a run, and the assessment."""

from collections.abc import Mapping
from functools import cache
from typing import Any, Literal, NamedTuple

from pydantic import BaseModel, ConfigDict

from rallygap.pipeline.paper.assessments import (
    NO_NUMBER,
    NOT_COMPARABLE,
    NOT_MEASURED,
    Interval,
    claim,
    combined,
    compared,
    rate,
    setting,
    within,
)
from rallygap.pipeline.paper.run_reports import Reading, Reports
from rallygap.pipeline.paper.sources import Source, number
from rallygap.pipeline.paper.values import group_rows, printed_values
from rallygap.pipeline.runtime.errors import InputError

NOTHING = "–"
CONTEXT = (
    "Shots, arm and policy differ from the paper's. Network and training are the paper's only in "
    "the profile paper; the tables of settings below say what this run has."
)


class Finding(NamedTuple):
    """What a run has for a number of the paper, with the assessment."""

    assessment: str
    value: float | str | None = None
    interval: Interval | None = None
    shown: str = NOTHING


class Value(BaseModel):
    """A number or claim of the paper; ``values.yaml`` describes the fields."""

    model_config = ConfigDict(extra="forbid", frozen=True)

    id: str
    what: str
    place: str
    value: float | str | None = None
    shown: str = ""
    unit: str = ""
    stage: str = NOTHING
    count: int | None = None
    of: int | None = None
    rule: Literal["same", "rate", "more", "less", "within", "every_horizon", "at_least", "quoted"]
    range: tuple[float, float] = (0.0, 0.0)
    ours: Source

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
            return f"{self.count} of {self.of}: {_with_unit(self.printed, '%')}"
        return self.shown or _with_unit(self.value, self.unit)

    def find(self, run: Reports) -> Finding:
        """Return what a run has for it.

        Raises:
            InputError: a report is broken, or a parameter of a kept run is.
        """
        try:
            found = self.ours.read(run)
        except (ArithmeticError, AttributeError, LookupError, TypeError, ValueError) as error:
            problem = f"cannot be compared: {error}; run the stage or `rallygap keep` again"
            raise InputError(run.written_in, problem, field=self.ours.place) from None
        if found is None:
            return Finding(NO_NUMBER if self.rule == "quoted" else NOT_MEASURED)
        return Finding(self._assessment(found), found.value, found.interval, self._text(found))

    def _assessment(self, found: Reading) -> str:
        if found.interval is None or found.assessment:
            return found.assessment or setting(
                found.value, self.value or 0.0, minimum=self.rule == "at_least"
            )
        if self.rule == "rate":
            return compared(found.interval, rate(self.count or 0, self.of or 0).times(100))
        if self.rule == "within":
            return within(found.interval, *self.range)
        return claim(found.interval, grows=self.rule == "more")

    def _text(self, found: Reading) -> str:
        if found.shown or found.interval is None:
            return found.shown or _with_unit(found.value, self.unit)
        value, low, high = map(number, found.interval)
        return f"{value} ({low} to {high}) {self.unit}".strip()


class Group(NamedTuple):
    """Values that belong together.

    Attributes:
        id: unique among groups.
        title: of the group.
        about: what is compared, and by which rule.
        axis: ends of the scale on which values are drawn; ``None`` where they are only written.
        needs: parameter that a run sets if it can be compared; empty if all can.
        values: in the paper's order.
    """

    id: str
    title: str
    about: str
    axis: tuple[float, float] | None
    needs: str
    values: tuple[Value, ...]

    def findings(self, run: Reports) -> list[tuple[Value, Finding]]:
        """Return what a run has for every value."""
        found = [(one, one.find(run)) for one in self.values]
        if not self.needs or run.param(self.needs) is not None:
            return found
        return [
            (value, one if one.value is None else one._replace(assessment=NOT_COMPARABLE))
            for value, one in found
        ]


class Exhibit(BaseModel):
    """A figure, table or algorithm of the paper; without claims it has no number.

    Attributes:
        name: as the paper numbers it.
        what: it shows.
        stage: that makes ours.
        ours: the files, relative to the reports; or where else it is.
        claims: ids of the groups that make its assessment.
    """

    model_config = ConfigDict(extra="forbid", frozen=True)

    name: str
    what: str
    stage: str
    ours: str
    claims: tuple[str, ...] = ()

    def assessment(self, run: Reports) -> str:
        """Return the assessment of it, from those on its claims."""
        if not self.claims:
            return NO_NUMBER
        claims = [one for one in groups() if one.id in self.claims]
        return combined(found.assessment for group in claims for _, found in group.findings(run))


@cache
def groups() -> tuple[Group, ...]:
    """Return all values of the paper, in groups."""
    return tuple(_group(one) for one in printed_values()["groups"])


def _group(one: Mapping[str, Any]) -> Group:
    axis = one.get("axis")
    return Group(
        one["id"],
        one["title"],
        one.get("about", ""),
        tuple(axis) if axis else None,
        one.get("needs", ""),
        tuple(Value.model_validate(row) for row in group_rows(one)),
    )


@cache
def exhibits() -> tuple[Exhibit, ...]:
    """Return the figures, tables and algorithms of the paper."""
    return tuple(map(Exhibit.model_validate, printed_values()["exhibits"]))


def compare(run: Reports) -> dict[str, Finding]:
    """Return what a run has for every value of the paper, by id.

    Raises:
        InputError: a report or a recorded parameter is broken.
    """
    return {value.id: found for group in groups() for value, found in group.findings(run)}


def _with_unit(value: float | str | None, unit: str) -> str:
    if value is None:
        return NOTHING
    return value if isinstance(value, str) else f"{number(value)} {unit}".strip()
