"""Tables of the exam, from its sheets."""

from collections import Counter
from collections.abc import Iterator, Sequence
from typing import Any

import pandas as pd

from models.exam.record import Answered, Sheet
from models.exam.scoring.rates import MARKS, alone, at_3x, mark, posed, rates, solved


def methods_of(sheets: Sequence[Sheet]) -> list[str]:
    """Return the methods that were asked, in their order."""
    return list(dict.fromkeys(method for one in sheets for method in one.answers))


def rate_table(sheets: Sequence[Sheet]) -> pd.DataFrame:
    """Return all rates with their counts: one row a method."""
    return pd.DataFrame([{"method": name, **rates(sheets, name)} for name in methods_of(sheets)])


def effect_table(sheets: Sequence[Sheet], method: str) -> pd.DataFrame:
    """Return how answers at 3x were marked: one row a parameter of the catalogue.

    ``own_class``: trials in which the data tell it from all others; ``not_posed``: in which they do
    not show it.
    """
    groups: dict[str, list[Sheet]] = {}
    for sheet in at_3x(sheets):
        groups.setdefault(sheet.asked[0], []).append(sheet)
    return pd.DataFrame([_effect_row(name, some, method) for name, some in groups.items()])


def _effect_row(name: str, sheets: Sequence[Sheet], method: str) -> dict[str, Any]:
    mine = posed(sheets, method)
    marks = Counter(mark(one, method) for one in mine)
    return {
        "hidden": name,
        "trials": len(mine),
        "own_class": sum(alone(one) for one in mine),
        "solved": sum(solved(one, method) for one in mine),
        **{one: marks[one] for one in MARKS},
        "not_posed": sum(one.not_posed is not None for one in sheets),
    }


def group_table(sheets: Sequence[Sheet], method: str) -> pd.DataFrame:
    """Return shares of solved questions: a row a group, sweeps by cell, and a column a method.

    ``removable_closed`` is the share of the removable gap that ``method`` closed.
    """
    groups: dict[tuple[str, str], list[Sheet]] = {}
    for sheet in sheets:
        groups.setdefault((sheet.group, sheet.cell), []).append(sheet)
    methods = methods_of(sheets)
    rows = [
        {
            "group": group,
            "cell": cell,
            "questions": len(some),
            "not_posed": sum(one.not_posed is not None for one in some),
            **{name: _solved_share(some, name) for name in methods},
            "removable_closed": rates(some, method)["removable_closed"],
        }
        for (group, cell), some in groups.items()
    ]
    return pd.DataFrame(rows)


def _solved_share(sheets: Sequence[Sheet], method: str) -> float | None:
    mine = posed(sheets, method)
    return sum(solved(one, method) for one in mine) / len(mine) if mine else None


def not_posed_table(sheets: Sequence[Sheet]) -> pd.DataFrame:
    """Return which questions could not be posed, how often and why, by what was to be hidden."""
    counts = Counter(
        (one.group, one.cell, " + ".join(one.asked), one.not_posed)
        for one in sheets
        if one.not_posed is not None
    )
    rows = [(*key, number) for key, number in counts.items()]
    return pd.DataFrame(rows, columns=["group", "cell", "hidden", "why", "questions"])


def answer_table(sheets: Sequence[Sheet], methods: Sequence[str]) -> pd.DataFrame:
    """Return one row a question and method: what was hidden, what was answered, its mark."""
    columns = ["trial", "method", "hidden", "answer", "causes", "mark", "solved"]
    rows = [
        _answer_row(sheet, method)
        for sheet in sheets
        for method in methods
        if method in sheet.answers
    ]
    return pd.DataFrame(rows, columns=columns)


def differing(fresh: Sequence[Sheet], kept: Sequence[Sheet]) -> list[str]:
    """Return the names of fresh sheets that the kept ones lack, or have with other answers.

    An answer is another one if it is in other words or names other causes; its digits may differ
    from machine to machine.
    """
    known = {one.name: one for one in kept}
    return [one.name for one in fresh if not _agree(one, known.get(one.name))]


def _agree(fresh: Sheet, kept: Sheet | None) -> bool:
    if kept is None or fresh.not_posed != kept.not_posed:
        return False
    both = fresh.answers.keys() & kept.answers.keys()
    return all(_said(fresh.answers[one]) == _said(kept.answers[one]) for one in both)


def _said(given: Answered) -> tuple[str | None, set[tuple[str, str]]]:
    return given.answer, {(cause.effect, cause.parameter) for cause in given.causes}


def shortfall_table(sheets: Sequence[Sheet], method: str) -> pd.DataFrame:
    """Return the rows of ``answer_table`` that are not solved."""
    answers = answer_table(sheets, [method])
    return answers[~answers["solved"].astype(bool)].drop(columns=["method", "solved"])


def _answer_row(sheet: Sheet, method: str) -> dict[str, Any]:
    given = sheet.answers[method]
    hidden = (f"{h.effect}.{h.parameter}={h.value:.4g}" for h in sheet.hidden)
    return {
        "trial": sheet.name,
        "method": method,
        "hidden": " + ".join(hidden) or "nothing",
        "answer": given.answer or given.error,
        "causes": " + ".join(_causes(given)),
        "mark": mark(sheet, method),
        "solved": solved(sheet, method),
    }


def _causes(given: Answered) -> Iterator[str]:
    for cause in given.causes:
        others = [name for name in cause.possible if name != cause.name]
        doubt = f" (or {', '.join(others)})" if others else ""
        yield f"{cause.effect}.{cause.parameter}={cause.estimate:.4g}{doubt}"
