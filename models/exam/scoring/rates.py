"""Scoring: from sheets to rates, the same for every method.

- *Right name*: the answer is ``named``, with exactly the hidden causes and no other.
- *Right class*: as many causes as are hidden, and each hidden one in the class of another of them.
- *Solved*: each hidden cause that is a class of its own on its data has the right name, each other
  one is in the class of a cause, and there is no other cause. On a clean set: ``no_gap``. Where the
  effect was withheld: ``unknown``.
- *False alarm*: any answer but ``no_gap`` on a clean set. A method that fails is wrong everywhere.
- *At 3x*: the sweeps' base, 100 shots and 3 mm.
- *Coverage*: of all numbers at 3x or more that have the right effect and parameter, in answers with
  the right causes and no other, the share whose 95 % interval holds the truth.
- *Removable gap closed*: over all trials with a cause that could be named, the sum of what an
  amended simulator takes away of the gap by the sum of the gap (removable.py). A method that fails
  takes nothing away.

Rates of nothing are None.
"""

from collections.abc import Iterable, Sequence
from itertools import permutations
from typing import Any, Literal

from scipy.stats import binomtest

from models.exam.design.questions import BASE, MULTIPLE
from models.exam.record import Answered, Hidden, Named, Sheet, rounded

Mark = Literal["right", "ambiguous", "wrong", "missed", "failed"]
MARKS: tuple[Mark, ...] = ("right", "ambiguous", "wrong", "missed", "failed")


def posed(sheets: Iterable[Sheet], method: str) -> list[Sheet]:
    """Return the sheets of questions that could be posed and that a method was asked."""
    return [one for one in sheets if method in one.answers]


def mark(sheet: Sheet, method: str) -> Mark:
    """Return what a method's answer is worth; ``ambiguous`` is the right class without a name."""
    given = sheet.answers[method]
    if given.answer is None:
        return "failed"
    if _right(sheet, given):
        return "right"
    if given.answer == "no_gap":
        return "missed"
    in_question = sheet.hidden and not sheet.withheld and given.answer != "unknown"
    return "ambiguous" if in_question and _matched(sheet, given, _in_class) else "wrong"


def solved(sheet: Sheet, method: str) -> bool:
    """Return whether an answer says all that the data show, and no more."""
    given = sheet.answers[method]
    if sheet.withheld or not sheet.hidden:
        return mark(sheet, method) == "right"
    return given.answer in ("named", "ambiguous") and _matched(sheet, given, _solves)


def at_3x(sheets: Iterable[Sheet]) -> list[Sheet]:
    """Return the sheets of the sweeps' base."""
    return [one for one in sheets if one.cell == BASE.name]


def of_group(sheets: Iterable[Sheet], group: str) -> list[Sheet]:
    """Return the sheets of a group."""
    return [one for one in sheets if one.group == group]


def alone(sheet: Sheet) -> bool:
    """Return whether every hidden cause is a class of its own on its data."""
    return not any(one.alike for one in sheet.hidden)


def covered(sheets: Iterable[Sheet], method: str) -> list[bool]:
    """Return for every rightly named number at 3x or more whether its interval holds the truth."""
    found = []
    for sheet in posed(sheets, method):
        given = sheet.answers[method]
        if sheet.multiple < MULTIPLE or sheet.withheld or not _exact(sheet, given):
            continue
        truth = {(one.effect, one.parameter): one.value for one in sheet.hidden}
        for cause in given.causes:
            if cause.interval is not None:
                low, high = cause.interval
                found.append(low <= truth[cause.effect, cause.parameter] <= high)
    return found


def closed(sheets: Iterable[Sheet], method: str) -> tuple[int, float, float]:
    """Return the number of trials with a gap to close, and sums of it before and after in mm."""
    pairs = [
        (sheet.before_mm, _after(sheet.answers[method].after_mm, sheet.before_mm))
        for sheet in posed(sheets, method)
        if sheet.before_mm is not None and not sheet.withheld
    ]
    return len(pairs), sum(before for before, _ in pairs), sum(after for _, after in pairs)


def interval(part: int, whole: int) -> tuple[float, float]:
    """Return the Clopper-Pearson 95 % interval of a share."""
    found = binomtest(part, whole).proportion_ci(0.95, "exact")
    return float(found.low), float(found.high)


def rates(sheets: Sequence[Sheet], method: str) -> dict[str, Any]:
    """Return all that is reported of a method, each rate after its counts."""
    mine = posed(sheets, method)
    base = at_3x(mine)
    return {
        "trials": len(mine),
        "failures": sum(mark(one, method) == "failed" for one in mine),
        **_false_alarms(of_group(mine, "clean"), method),
        **_solved([one for one in base if alone(one)], method, "own_class", "top1_at_3x"),
        **_solved([one for one in base if not alone(one)], method, "shared_class", "class_at_3x"),
        **_solved(of_group(mine, "pair"), method, "pairs", "pairs_both"),
        **_solved(of_group(mine, "withheld"), method, "withheld", "unknown_recall"),
        **_coverage(mine, method),
        **_closed(mine, method),
    }


def _false_alarms(clean: Sequence[Sheet], method: str) -> dict[str, Any]:
    alarms = sum(mark(one, method) != "right" for one in clean)
    upper = None
    if clean:
        # One-sided: with 95 % confidence the rate is no larger.
        test = binomtest(alarms, len(clean), alternative="less")
        upper = rounded(float(test.proportion_ci(0.95, "exact").high))
    return {
        "clean_sets": len(clean),
        "false_alarms": alarms,
        "false_alarm_rate": _share(alarms, len(clean)),
        "false_alarm_upper95": upper,
    }


def _solved(sheets: Sequence[Sheet], method: str, counted: str, rate: str) -> dict[str, Any]:
    right = sum(solved(one, method) for one in sheets)
    return {counted: len(sheets), f"{counted}_right": right, rate: _share(right, len(sheets))}


def _coverage(sheets: Sequence[Sheet], method: str) -> dict[str, Any]:
    held = covered(sheets, method)
    share = _share(sum(held), len(held))
    return {"intervals": len(held), "intervals_right": sum(held), "coverage": share}


def _closed(sheets: Sequence[Sheet], method: str) -> dict[str, Any]:
    trials, before, after = closed(sheets, method)
    share = rounded((before - after) / before) if before else None
    return {
        "gaps": trials,
        "gap_before_mm": rounded(before),
        "gap_after_mm": rounded(after),
        "removable_closed": share,
    }


def _share(part: int, whole: int) -> float | None:
    return rounded(part / whole) if whole else None


def _after(after: float | None, before: float) -> float:
    return before if after is None else after


def _right(sheet: Sheet, given: Answered) -> bool:
    if not sheet.hidden:
        return given.answer == "no_gap"
    if sheet.withheld:
        return given.answer == "unknown"
    return given.answer == "named" and _exact(sheet, given)


def _exact(sheet: Sheet, given: Answered) -> bool:
    return given.answer in ("named", "ambiguous") and _matched(sheet, given, _same)


def _matched(sheet: Sheet, given: Answered, fits: Any) -> bool:
    """Return whether causes fit what is hidden, one to one."""
    if len(given.causes) != len(sheet.hidden):
        return False
    return any(
        all(fits(one, cause) for one, cause in zip(sheet.hidden, order, strict=True))
        for order in permutations(given.causes)
    )


def _same(hidden: Hidden, cause: Named) -> bool:
    return (hidden.effect, hidden.parameter) == (cause.effect, cause.parameter)


def _in_class(hidden: Hidden, cause: Named) -> bool:
    return hidden.name in cause.possible


def _solves(hidden: Hidden, cause: Named) -> bool:
    """Return whether a cause says what data show of one that is hidden."""
    if hidden.alike:
        return _in_class(hidden, cause)
    return _same(hidden, cause) and set(cause.possible) == {hidden.name}
