"""Assessments of our numbers by the paper's, each by a rule on the 95 % interval."""

import math
from collections.abc import Iterable
from typing import NamedTuple

from scipy.stats import binomtest

SAME, DIFFERS = "same", "differs"  # settings and sizes
# Measured rates against printed ones.
NOT_DIFFERENT, HIGHER, LOWER = "not different", "higher", "lower"
HOLDS, OPEN, FAILS = "holds", "open", "fails"  # claims
NOT_COMPARABLE = "not comparable"
NOT_MEASURED = "not measured"
NO_NUMBER = "no number"

MEANINGS = {
    SAME: "a setting or size equal to the paper's within 1 %, or not below a minimum",
    DIFFERS: "any other setting or size",
    NOT_DIFFERENT: "the 95 % interval of our rate minus the paper's contains zero",
    HIGHER: "the 95 % interval of our rate minus the paper's is above zero",
    LOWER: "the 95 % interval of our rate minus the paper's is below zero",
    HOLDS: "the whole 95 % interval agrees with the claim; of a figure: in all its rows",
    OPEN: "the 95 % interval includes both outcomes; of a figure: in some row, and no row fails",
    FAILS: "the whole 95 % interval contradicts the claim; of a figure: in some row",
    NOT_COMPARABLE: "both numbers exist, but the experiments differ in what decides the outcome",
    NOT_MEASURED: "the reports of the run do not have the number",
    NO_NUMBER: "a sketch, or a number that the paper quotes from other work",
}


class Interval(NamedTuple):
    """A number with the ends of its 95 % interval."""

    value: float
    low: float
    high: float

    def times(self, factor: float) -> "Interval":
        """Return it in another unit, or with the other sign."""
        low, high = sorted((factor * self.low, factor * self.high))
        return Interval(factor * self.value, low, high)


class Finding(NamedTuple):
    """What a run has for a number of the paper.

    Attributes:
        assessment: empty where the rule of the value gives it.
        value: the number; text where it is none, ``None`` where there is none.
        interval: of 95 %, where there is one.
        shown: how it is written; empty where value, interval and unit say it.
    """

    assessment: str = ""
    value: float | str | None = None
    interval: Interval | None = None
    shown: str = ""


def setting(ours: float | str, printed: float | str, *, minimum: bool = False) -> str:
    """Return whether a setting equals the paper's, or reaches it where that is a minimum."""
    if isinstance(ours, str) or isinstance(printed, str):
        return SAME if ours == printed else DIFFERS
    if minimum and ours > printed:
        return SAME
    return SAME if math.isclose(ours, printed, rel_tol=0.01) else DIFFERS


def difference(first: Interval, second: Interval) -> Interval:
    """Return the difference of two independent numbers with its interval (Zou and Donner 2008)."""
    value = first.value - second.value
    below = math.hypot(first.value - first.low, second.high - second.value)
    above = math.hypot(first.high - first.value, second.value - second.low)
    return Interval(value, value - below, value + above)


def rate(count: int, of: int) -> Interval:
    """Return a rate with its interval (Wilson 1927)."""
    ends = binomtest(count, of).proportion_ci(method="wilson")
    return Interval(count / of, ends.low, ends.high)


def compared(ours: Interval, printed: Interval) -> str:
    """Return whether a rate of ours is higher or lower than the paper's."""
    gap = difference(ours, printed)
    if gap.low > 0:
        return HIGHER
    return LOWER if gap.high < 0 else NOT_DIFFERENT


def claim(change: Interval, *, grows: bool = True) -> str:
    """Return whether a change has the sign that the paper claims."""
    towards = change if grows else change.times(-1)
    if towards.low > 0:
        return HOLDS
    return FAILS if towards.high < 0 else OPEN


def within(ours: Interval, low: float, high: float) -> str:
    """Return whether a number lies in the range that a claim allows."""
    if low <= ours.low and ours.high <= high:
        return HOLDS
    return FAILS if ours.high < low or ours.low > high else OPEN


def combined(parts: Iterable[str]) -> str:
    """Return the assessment of a claim from the assessments of its parts."""
    words = set(parts)
    for word in (FAILS, NOT_MEASURED, OPEN, NOT_COMPARABLE):
        if word in words:
            return word
    return HOLDS if words else NOT_MEASURED
