"""Tables of the exam, from its records."""

from collections import Counter
from collections.abc import Sequence
from typing import Any

import pandas as pd

from rallygap.models.exam.records import ExamRecord
from rallygap.models.exam.scoring.rates import (
    MARKS,
    answered,
    distinguishable,
    mark,
    of_base,
    of_robustness,
    rates,
    removable_closed,
    solved,
)
from rallygap.pipeline.exam.answers import answer_rows, methods_of
from rallygap.pipeline.web.report_items import ReportTable

SOLVED = (
    "A question is solved if the answer names the hidden cause where the data distinguish it from "
    "all other parameters, otherwise lists it among the possible ones, and names no other cause. "
    "On clean sets the right answer is no_gap, with a withheld effect unknown."
)
ROBUSTNESS_COLUMNS = (  # keys of ``rates``
    *("clean_sets_new", "false_leading", "constant_new", "leading_right", "exact_right"),
    *("intervals_new", "intervals_new_right", "varying_new", "varying_new_right"),
)


def rate_table(records: Sequence[ExamRecord]) -> ReportTable:
    """Return all rates with their counts: one row a rate, one column a method."""
    columns = {method: pd.Series(rates(records, method)) for method in methods_of(records)}
    table = pd.DataFrame(columns).rename_axis("rate").reset_index()
    return ReportTable(table, "rates", "The exam: rates by method", "Every rate after its counts.")


def effect_table(records: Sequence[ExamRecord], method: str) -> ReportTable:
    """Return the marks at 3 detection limits: one row a parameter of the catalogue."""
    groups: dict[str, list[ExamRecord]] = {}
    for record in of_base(records):
        groups.setdefault(record.parameters[0], []).append(record)
    return ReportTable(
        pd.DataFrame([_effect_row(name, some, method) for name, some in groups.items()]),
        "effects",
        title="The exam: marks by parameter",
        caption=f"Answers of {method} at 3 detection limits, 100 shots and 3 mm noise. "
        "distinguishable: trials in which the data distinguish the parameter from all others. "
        "not_posed: trials in which no value within its bounds is detectable.",
    )


def _effect_row(name: str, records: Sequence[ExamRecord], method: str) -> dict[str, Any]:
    given = answered(records, method)
    marks = Counter(mark(record, method) for record in given)
    return {
        "hidden": name,
        "trials": len(given),
        "distinguishable": sum(distinguishable(record) for record in given),
        "solved": sum(solved(record, method) for record in given),
        **{one: marks[one] for one in MARKS},
        "not_posed": sum(record.not_posed is not None for record in records),
    }


def group_table(records: Sequence[ExamRecord], method: str) -> ReportTable:
    """Return shares of solved questions: a row a group, sweeps by cell, and a column a method."""
    groups: dict[tuple[str, str], list[ExamRecord]] = {}
    for record in records:
        groups.setdefault((record.group, record.cell), []).append(record)
    methods = methods_of(records)
    rows = [
        {
            "group": group,
            "cell": cell,
            "questions": len(some),
            "not_posed": sum(record.not_posed is not None for record in some),
            **{name: _solved_share(some, name) for name in methods},
            "removable_closed": removable_closed(some, method),
        }
        for (group, cell), some in groups.items()
    ]
    return ReportTable(
        pd.DataFrame(rows),
        "groups",
        title="The exam: solved questions by group",
        caption=f"Share of solved questions by method. {SOLVED} removable_closed: share of the "
        f"removable gap that {method} closes.",
    )


def robustness_table(records: Sequence[ExamRecord], method: str) -> ReportTable:
    """Return the counts of the robustness groups: a row a group and part."""
    groups: dict[tuple[str, str], list[ExamRecord]] = {}
    for record in of_robustness(records):
        groups.setdefault((record.group, record.cell), []).append(record)
    rows = []
    for key, some in groups.items():
        found = rates(some, method)
        rows.append((*key, *(found[name] for name in ROBUSTNESS_COLUMNS)))
    return ReportTable(
        pd.DataFrame(rows, columns=["group", "part", *ROBUSTNESS_COLUMNS]),
        "robustness",
        title="The exam: robustness groups",
        caption=f"Answers of {method}. false_leading: clean sets in which a physical cause is "
        "named. leading_right: sets in which the leading cause is named; exact_right: solved sets. "
        "varying_new_right: sets with a cause that varies in which no other cause is named, and "
        "the answer is not no_gap.",
    )


def _solved_share(records: Sequence[ExamRecord], method: str) -> float | None:
    given = answered(records, method)
    return sum(solved(record, method) for record in given) / len(given) if given else None


def not_posed_table(records: Sequence[ExamRecord]) -> ReportTable:
    """Return which questions could not be posed, how often and why."""
    counts = Counter(
        (record.group, record.cell, " + ".join(record.parameters), record.not_posed)
        for record in records
        if record.not_posed is not None
    )
    rows = [(*key, number) for key, number in counts.items()]
    return ReportTable(
        pd.DataFrame(rows, columns=["group", "cell", "hidden", "reason", "questions"]),
        "not_posed",
        title="The exam: questions that could not be posed",
        caption="Parameters to hide, and the reason why they could not be hidden.",
    )


def shortfall_table(records: Sequence[ExamRecord], method: str) -> ReportTable:
    """Return the answers that do not solve their question."""
    answers = answer_rows(records, [method])
    return ReportTable(
        answers[~answers["solved"].astype(bool)].drop(columns=["method", "solved"]),
        "shortfalls",
        title="The exam: questions not solved",
        caption=f"Every question that {method} does not solve, by trial.",
    )
