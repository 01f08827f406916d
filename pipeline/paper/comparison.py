"""The comparison: every number and claim of the paper, ours from a run, and the assessment."""

from functools import cache
from pathlib import Path
from typing import NamedTuple

from rallygap.pipeline.paper.assessments import (
    NO_NUMBER,
    NOT_COMPARABLE,
    NOT_MEASURED,
    Finding,
    claim,
    combined,
    compared,
    rate,
    setting,
    within,
)
from rallygap.pipeline.paper.run_reports import Reports
from rallygap.pipeline.paper.sources import READERS
from rallygap.pipeline.paper.values import NOTHING, Value, number, printed_values, with_unit
from rallygap.pipeline.params import read_yaml
from rallygap.pipeline.runtime.errors import InputError

GROUPS = Path(__file__).with_name("groups.yaml")
ABOUT_TWICE = (1.5, 2.5)
CONTEXT = (
    "Shots, arm and policy differ from the paper's. Network and training are the paper's only in "
    "the profile paper; the tables of settings below say what this run has."
)


class Group(NamedTuple):
    """Values that belong together.

    Attributes:
        id: unique among groups.
        title: of the group.
        about: what is compared, and by which rule.
        axis: ends of the scale on which values are drawn; ``None`` where they are only written.
        needs: parameter that a run sets if it can be compared; empty if all can.
    """

    id: str
    title: str
    about: str = ""
    axis: tuple[float, float] | None = None
    needs: str = ""

    @property
    def values(self) -> tuple[Value, ...]:
        """The values, in the paper's order."""
        return tuple(value for value in printed_values() if value.group == self.id)

    def findings(self, run: Reports) -> list[tuple[Value, Finding]]:
        """Return what a run has for every value.

        Raises:
            InputError: a report is broken, or a parameter of a kept run is.
        """
        pairs = [(value, _find(value, run)) for value in self.values]
        if not self.needs or run.param(self.needs) is not None:
            return pairs
        return [
            (value, ours if ours.value is None else ours._replace(assessment=NOT_COMPARABLE))
            for value, ours in pairs
        ]


class Exhibit(NamedTuple):
    """A figure, table or algorithm of the paper; without claims it has no number.

    Attributes:
        name: as the paper numbers it.
        what: it shows.
        stage: that makes ours.
        ours: the files, relative to the reports; or where else it is.
        claims: ids of the groups that make its assessment.
    """

    name: str
    what: str
    stage: str
    ours: str
    claims: tuple[str, ...] = ()

    def assessment(self, run: Reports) -> str:
        """Return the assessment of it, from those on its claims."""
        if not self.claims:
            return NO_NUMBER
        claims = [group for group in groups() if group.id in self.claims]
        return combined(
            finding.assessment for group in claims for _, finding in group.findings(run)
        )


@cache
def groups() -> tuple[Group, ...]:
    """Return the groups of all values of the paper."""
    return tuple(Group(**group) for group in read_yaml(GROUPS)["groups"])


@cache
def exhibits() -> tuple[Exhibit, ...]:
    """Return the figures, tables and algorithms of the paper."""
    return tuple(Exhibit(**exhibit) for exhibit in read_yaml(GROUPS)["exhibits"])


def compare(run: Reports) -> dict[str, Finding]:
    """Return what a run has for every value of the paper, by id.

    Raises:
        InputError: a report or a recorded parameter is broken.
    """
    return {value.id: finding for group in groups() for value, finding in group.findings(run)}


def _find(value: Value, run: Reports) -> Finding:
    try:
        finding = READERS[value.source](value, run)
    except (ArithmeticError, AttributeError, LookupError, TypeError, ValueError) as error:
        problem = f"cannot be compared: {error}; run the stage again"
        raise InputError(run.written_in, problem, field=value.ours) from None
    if finding is None:
        return Finding(NO_NUMBER if value.rule == "quoted" else NOT_MEASURED, shown=NOTHING)
    shown = with_unit(finding.value, value.unit)
    if finding.interval is not None:
        ours, low, high = map(number, finding.interval)
        shown = f"{ours} ({low} to {high}) {value.unit}".strip()
    return finding._replace(
        assessment=finding.assessment or _assessment(value, finding), shown=finding.shown or shown
    )


def _assessment(value: Value, ours: Finding) -> str:
    if ours.interval is None:
        is_minimum = value.rule == "at_least"
        return setting(ours.value or 0.0, value.value or 0.0, minimum=is_minimum)
    if value.rule == "rate":
        return compared(ours.interval, rate(value.count or 0, value.of or 0).times(100))
    if value.rule == "twice":
        return within(ours.interval, *ABOUT_TWICE)
    return claim(ours.interval, grows=value.rule == "more")
