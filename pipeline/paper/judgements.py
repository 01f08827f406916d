"""Verdicts: one word on a number of ours beside the paper's, by rule."""

import math
from collections.abc import Iterable
from typing import NamedTuple

SAME, DIFFERS = "same", "differs"  # settings and sizes
LEVEL, HIGHER, LOWER = "level", "higher", "lower"  # measured numbers beside printed ones
HOLDS, OPEN, FAILS = "holds", "open", "fails"  # claims
NOT_MEASURED = "not measured"
NO_NUMBER = "no number"

MEANINGS = {
    SAME: "a setting or size as in the paper, to 1 %",
    DIFFERS: "another one",
    LEVEL: "the 95 % interval of ours minus the paper's holds zero",
    HIGHER: "that interval lies above zero",
    LOWER: "that interval lies below zero",
    HOLDS: "a claim of the paper, and the whole 95 % interval of ours is on its side, in all parts",
    OPEN: "the interval reaches over zero in some part, and contradicts the claim in none",
    FAILS: "in some part the whole interval contradicts the claim",
    NOT_MEASURED: "the reports do not have it",
    NO_NUMBER: "a drawing, or a number that the paper quotes from others",
}

NORMAL = 1.96  # standard deviations on each side that hold 95 %


class Interval(NamedTuple):
    """A number with the ends of its 95 % interval."""

    value: float
    low: float
    high: float

    def times(self, factor: float) -> "Interval":
        """Return it in another unit, or with the other sign."""
        low, high = sorted((factor * self.low, factor * self.high))
        return Interval(factor * self.value, low, high)


def setting(ours: float | str | None, printed: float | str) -> str:
    """Return whether a setting is the paper's."""
    if ours is None:
        return NOT_MEASURED
    if isinstance(ours, str) or isinstance(printed, str):
        return SAME if ours == printed else DIFFERS
    return SAME if math.isclose(ours, printed, rel_tol=0.01) else DIFFERS


def minus(one: Interval, other: Interval) -> Interval:
    """Return the difference of two numbers measured apart, its interval from theirs.

    Zou and Donner 2008: independent numbers whose intervals need not lie even about them.
    """
    value = one.value - other.value
    below = math.hypot(one.value - one.low, other.high - other.value)
    above = math.hypot(one.high - one.value, other.value - other.low)
    return Interval(value, value - below, value + above)


def beside(ours: Interval, printed: Interval) -> str:
    """Return where a number of ours lies, seen from the paper's."""
    difference = minus(ours, printed)
    if difference.low > 0:
        return HIGHER
    return LOWER if difference.high < 0 else LEVEL


def share(count: int, of: int) -> Interval:
    """Return a share with its interval (Wilson 1927)."""
    middle, spread = (
        count + NORMAL**2 / 2,
        NORMAL * math.sqrt(count * (of - count) / of + NORMAL**2 / 4),
    )
    whole = of + NORMAL**2
    return Interval(count / of, (middle - spread) / whole, (middle + spread) / whole)


def claim(difference: Interval, *, grows: bool = True) -> str:
    """Return whether a difference has the sign that the paper claims, up or down."""
    towards = difference if grows else difference.times(-1)
    if towards.low > 0:
        return HOLDS
    return FAILS if towards.high < 0 else OPEN


def within(ours: Interval, low: float, high: float) -> str:
    """Return whether a number lies within the ends that a claim allows."""
    if low <= ours.low and ours.high <= high:
        return HOLDS
    return FAILS if ours.high < low or ours.low > high else OPEN


def of_all(parts: Iterable[str]) -> str:
    """Return the verdict on a claim from those on its parts."""
    found = set(parts)
    for word in (FAILS, NOT_MEASURED, OPEN):
        if word in found:
            return word
    return HOLDS if found else NOT_MEASURED
