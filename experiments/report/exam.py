"""The report of `exam`: rates of the exam, by group, effect and method.

A function takes records of answered questions, and the method, or methods, that it is about.
"""

from collections import Counter
from collections.abc import Callable, Iterable, Iterator, Sequence
from operator import attrgetter
from typing import Any

import numpy as np
import pandas as pd
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from experiments.exam.design.questions import BASE, SWEEPS
from experiments.exam.records import RECORDS, AnswerRecord, ExamRecord, read_records
from experiments.exam.scoring.rates import (
    MARKS,
    answered,
    covered,
    distinguishable,
    interval,
    mark,
    of_base,
    of_group,
    of_robustness,
    of_sweeps,
    rates,
    removable_closed,
    solved,
)
from experiments.report.answers import answer_rows, methods_of
from rallygap.models.ball.types import Floats
from rallygap.pipeline.report.plots import add_legend
from rallygap.pipeline.runtime.stage_run import StageRun
from rallygap.pipeline.web.figure_style import FIGURE_WIDTH, INK, MUTED
from rallygap.pipeline.web.report_items import ReportFigure, ReportItem, ReportTable

Records = Sequence[ExamRecord]

SOLVED = (
    "A question is solved if the answer names the hidden cause where the data distinguish it from "
    "all other parameters, otherwise lists it among the possible ones, and names no other cause. "
    "On clean sets the right answer is no_gap, with a withheld effect unknown."
)
OTHERS = ("no gap", "unknown", "several", "failed")  # answers other than one cause
TARGET = (93, 97)  # %, of the coverage of a 95 % interval
COLOURS = {
    "rallygap": "#0f7fc4",
    "sindy": "#d55e00",
    "sindy_ensemble": "#b85fa0",
    "evidence_greedy": "#b8860b",
    "identification": "#009988",
}
LABELS = {
    "rallygap": "rallygap",
    "sindy": "SINDy",
    "sindy_ensemble": "SINDy, ensemble",
    "evidence_greedy": "evidence, greedy",
    "identification": "identification",
}
# Axis label: keys of the number of trials and of the counted ones.
RATES = {
    "false alarms\non clean sets": ("clean_sets", "false_alarms"),
    "right cause\nat 3 limits": ("distinguishable", "distinguishable_right"),
    "right class\nat 3 limits": ("indistinguishable", "indistinguishable_right"),
    "both of\ntwo causes": ("pairs", "pairs_right"),
    "unknown for\nwithheld effects": ("withheld", "withheld_right"),
    "coverage of\nintervals": ("intervals", "intervals_right"),
}
WIDTH = 0.6  # of all marks of a rate
APART = 1.03  # factor between the places of two methods on a logarithmic axis
PANELS: dict[str, Callable[[Any], float]] = {  # settings of a cell
    "size (detection limits)": lambda cell: cell.multiple,
    "number of shots": lambda cell: cell.shots,
    "noise of a coordinate (mm)": lambda cell: 1000 * cell.noise,
}
ROBUSTNESS_COLUMNS = (  # keys of ``rates``
    *("clean_sets_new", "false_leading", "constant_new", "leading_right", "exact_right"),
    *("intervals_new", "intervals_new_right", "varying_new", "varying_new_right"),
)


def items(run: StageRun) -> Iterator[ReportItem]:
    """Yield figures and tables of the records.

    Figures leave the robustness groups out; their rates are in a table.
    """
    records = read_records(run.root / RECORDS)
    sweeps, methods = of_sweeps(records), methods_of(records)
    yield confusion_figure(sweeps, methods[0])
    yield accuracy_figure(sweeps, methods)
    yield coverage_figure(sweeps, methods[0])
    yield methods_figure(sweeps, methods)
    yield rate_table(records)
    yield effect_table(records, methods[0])
    yield group_table(records, methods[0])
    yield robustness_table(records, methods[0])
    yield shortfall_table(records, methods[0])
    yield not_posed_table(records)


def confusion_figure(records: Records, method: str) -> ReportFigure:
    """Return the confusion matrix of a method at 3 detection limits, with clean sets below."""
    given = answered([*of_base(records), *of_group(records, "clean")], method)
    counts = Counter((_hidden(record), _named(record.answers[method])) for record in given)
    parameters = sorted({record.parameters[0] for record in of_base(records)})
    rows = [*parameters, "nothing"]
    others = sorted({column for _, column in counts} - {*parameters, *OTHERS})
    columns = [*parameters, *others, *OTHERS]
    table = np.array([[counts[row, column] for column in columns] for row in rows], dtype=float)
    figure = Figure(figsize=(FIGURE_WIDTH, 1.2 + 0.185 * len(rows)))
    _draw_shares(figure.subplots(), table, rows, columns)
    return ReportFigure(
        figure,
        "confusion",
        title="Hidden and named causes",
        caption=f"Answers of {method}: each parameter at 3 detection limits in 100 shots, and "
        "clean sets. Where an answer lists several possible parameters, its first one is shown.",
    )


def _draw_shares(axes: Axes, counts: Floats, rows: list[str], columns: list[str]) -> None:
    total = counts.sum(axis=1)
    share = counts / np.maximum(total, 1.0)[:, None]
    axes.imshow(share, cmap="Blues", vmin=0, vmax=1, aspect="auto")
    for row, column in np.argwhere(counts > 0):
        value = share[row, column]
        colour = "white" if value > 0.5 else INK
        text = f"{100 * value:.0f}"
        axes.text(column, row, text, ha="center", va="center", fontsize=5.5, color=colour)
    labels = [f"{name} ({count:.0f})" for name, count in zip(rows, total, strict=True)]
    axes.set_yticks(range(len(rows)), labels, fontsize=6.5)
    axes.set_xticks(range(len(columns)), columns, fontsize=6.5, rotation=90)
    axes.set(ylabel="hidden parameter (trials)", xlabel="answer (% of trials)")
    axes.axhline(len(rows) - 1.5, color=MUTED, lw=0.8)
    axes.axvline(len(columns) - len(OTHERS) - 0.5, color=MUTED, lw=0.8)
    axes.grid(visible=False)


def _hidden(record: ExamRecord) -> str:
    return record.parameters[0] if record.hidden else "nothing"


def _named(answer: AnswerRecord) -> str:
    if answer.conclusion in (None, "no_gap", "unknown"):
        return {None: "failed", "no_gap": "no gap", "unknown": "unknown"}[answer.conclusion]
    return answer.causes[0].identity if len(answer.causes) == 1 else "several"


def coverage_figure(records: Records, method: str) -> ReportFigure:
    """Return how often 95 % intervals contain the true value, by group of questions."""
    groups = _grouped(
        records, lambda record: f"{record.group} {record.cell}".strip().replace("_", " ")
    )
    contains = {name: covered(members, method) for name, members in groups.items()}
    contains = {"all": [flag for flags in contains.values() for flag in flags], **contains}
    shown = {f"{name} ({len(flags)})": flags for name, flags in contains.items() if flags}
    figure = Figure(figsize=(FIGURE_WIDTH, 1.2 + 0.22 * max(len(shown), 1)))
    axes = figure.subplots()
    axes.axvspan(*TARGET, color="#dfe9f2", lw=0)
    for place, flags in enumerate(shown.values()):
        low, high = interval(sum(flags), len(flags))
        axes.plot([100 * low, 100 * high], [place, place], color=COLOURS["rallygap"])
        axes.plot(100 * sum(flags) / len(flags), place, "o", ms=4, color=COLOURS["rallygap"])
    axes.set_yticks(range(len(shown)), list(shown))
    axes.invert_yaxis()
    axes.set(xlabel="intervals that contain the true value (%)")
    return ReportFigure(
        figure,
        "coverage",
        title="Coverage of 95 % intervals",
        caption=f"Correctly named parameters of {method} at 3 detection limits or more (number in "
        "brackets): share whose interval contains the true value, with its 95 % interval. The "
        f"band is {TARGET[0]} to {TARGET[1]} %.",
    )


def accuracy_figure(records: Records, methods: Sequence[str]) -> ReportFigure:
    """Return the share of solved questions of the sweeps, against size, shots and noise."""
    figure = Figure(figsize=(FIGURE_WIDTH, 3.2))
    grid = figure.subplots(1, len(PANELS), sharey=True)
    for axes, (label, setting) in zip(grid, PANELS.items(), strict=True):
        varied = [cell for cell in SWEEPS if setting(cell) != setting(BASE)]
        cells = {cell.name: setting(cell) for cell in sorted([BASE, *varied], key=setting)}
        for method in methods:
            _draw_solved(axes, records, method, cells)
        axes.set(xlabel=label, xscale="log", ylim=(0, 103))
        axes.set_xticks(list(cells.values()), [f"{value:g}" for value in cells.values()])
        axes.minorticks_off()
    grid[0].set_ylabel("solved questions (%)")
    add_legend(figure, grid[0], loc="outside upper left", ncols=len(methods))
    return ReportFigure(
        figure,
        "accuracy",
        title="Solved questions by size, number of shots and noise",
        caption=f"One setting is varied at a time. {SOLVED} Whiskers: 95 % intervals. Marks of "
        "the methods are shifted a little, so that these can be distinguished.",
    )


def _draw_solved(axes: Axes, records: Records, method: str, cells: dict[str, float]) -> None:
    shares: dict[float, tuple[float, float, float]] = {}
    for cell, setting in cells.items():
        given = answered([record for record in records if record.cell == cell], method)
        if given:
            right = sum(solved(record, method) for record in given)
            shares[setting] = (right / len(given), *interval(right, len(given)))
    if shares:
        middle, low, high = 100 * np.array(list(shares.values())).T
        positions = np.array(list(shares)) * APART ** list(COLOURS).index(method)
        axes.errorbar(
            positions, middle, [middle - low, high - middle], fmt="o-", ms=3.5, lw=1.4,
            elinewidth=0.8, color=COLOURS[method], label=LABELS[method],
        )  # fmt: skip


def methods_figure(records: Records, methods: Sequence[str]) -> ReportFigure:
    """Return all rates and the closed share of the removable gap, one mark a method."""
    figure = Figure(figsize=(FIGURE_WIDTH, 3.4))
    axes = figure.subplots()
    for number, method in enumerate(methods):
        shift = WIDTH * ((number + 0.5) / len(methods) - 0.5)
        _draw_rates(axes, rates(records, method), shift, method)
    names = [*RATES, "removable\ngap closed"]
    axes.set_xticks(range(len(names)), names, fontsize=7.5)
    axes.set(ylabel="share (%)", ylim=(-2, 103))
    axes.grid(visible=False, axis="x")
    add_legend(figure, axes, loc="outside upper left", ncols=len(methods))
    return ReportFigure(
        figure,
        "methods",
        title="All rates by method",
        caption="The methods answer the same questions from the same recordings, the others a "
        "sample of them. Whiskers: 95 % intervals. Where there is no mark, there are no answers.",
    )


def _draw_rates(axes: Axes, numbers: dict[str, Any], shift: float, method: str) -> None:
    style: dict[str, Any] = {"color": COLOURS[method], "ms": 4}
    if numbers["removable_closed"] is not None:
        axes.plot(len(RATES) + shift, 100 * max(numbers["removable_closed"], 0.0), "o", **style)
    axes.plot([], [], "o", label=LABELS[method], **style)
    for place, (trials, counted) in enumerate(RATES.values()):
        if numbers[trials]:
            share = 100 * numbers[counted] / numbers[trials]
            low, high = (100 * end for end in interval(numbers[counted], numbers[trials]))
            ends = [[share - low], [high - share]]
            axes.errorbar(place + shift, share, ends, fmt="o", elinewidth=0.9, **style)


def rate_table(records: Records) -> ReportTable:
    """Return all rates with their counts: one row a rate, one column a method."""
    columns = {method: pd.Series(rates(records, method)) for method in methods_of(records)}
    table = pd.DataFrame(columns).rename_axis("rate").reset_index()
    return ReportTable(table, "rates", "The exam: rates by method", "Every rate after its counts.")


def effect_table(records: Records, method: str) -> ReportTable:
    """Return the marks at 3 detection limits: one row a parameter of the catalogue."""
    groups = _grouped(of_base(records), lambda record: record.parameters[0])
    return ReportTable(
        pd.DataFrame([_effect_row(name, members, method) for name, members in groups.items()]),
        "effects",
        title="The exam: marks by parameter",
        caption=f"Answers of {method} at 3 detection limits, 100 shots and 3 mm noise. "
        "distinguishable: trials in which the data distinguish the parameter from all others. "
        "not_posed: trials in which no value within its bounds is detectable.",
    )


def _effect_row(name: str, records: Records, method: str) -> dict[str, Any]:
    given = answered(records, method)
    marks = Counter(mark(record, method) for record in given)
    return {
        "hidden": name,
        "trials": len(given),
        "distinguishable": sum(distinguishable(record) for record in given),
        "solved": sum(solved(record, method) for record in given),
        **{word: marks[word] for word in MARKS},
        "not_posed": sum(record.not_posed is not None for record in records),
    }


def group_table(records: Records, method: str) -> ReportTable:
    """Return shares of solved questions: a row a group, sweeps by cell, and a column a method."""
    groups = _grouped(records, attrgetter("group", "cell"))
    methods = methods_of(records)
    rows = [
        {
            "group": group,
            "cell": cell,
            "questions": len(members),
            "not_posed": sum(record.not_posed is not None for record in members),
            **{name: _solved_share(members, name) for name in methods},
            "removable_closed": removable_closed(members, method),
        }
        for (group, cell), members in groups.items()
    ]
    return ReportTable(
        pd.DataFrame(rows),
        "groups",
        title="The exam: solved questions by group",
        caption=f"Share of solved questions by method. {SOLVED} removable_closed: share of the "
        f"removable gap that {method} closes.",
    )


def robustness_table(records: Records, method: str) -> ReportTable:
    """Return the counts of the robustness groups: a row a group and part."""
    groups = _grouped(of_robustness(records), attrgetter("group", "cell"))
    rows = [
        {"group": group, "part": part, **rates(members, method)}
        for (group, part), members in groups.items()
    ]
    return ReportTable(
        pd.DataFrame(rows, columns=["group", "part", *ROBUSTNESS_COLUMNS]),
        "robustness",
        title="The exam: robustness groups",
        caption=f"Answers of {method}. false_leading: clean sets in which a physical cause is "
        "named. leading_right: sets in which the leading cause is named; exact_right: solved sets. "
        "varying_new_right: sets with a cause that varies in which no other cause is named, and "
        "the answer is not no_gap.",
    )


def _grouped(
    records: Iterable[ExamRecord], key: Callable[[ExamRecord], Any]
) -> dict[Any, list[ExamRecord]]:
    """Return records by key, in the order of their first ones."""
    groups: dict[Any, list[ExamRecord]] = {}
    for record in records:
        groups.setdefault(key(record), []).append(record)
    return groups


def _solved_share(records: Records, method: str) -> float | None:
    given = answered(records, method)
    return sum(solved(record, method) for record in given) / len(given) if given else None


def not_posed_table(records: Records) -> ReportTable:
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


def shortfall_table(records: Records, method: str) -> ReportTable:
    """Return the answers that do not solve their question."""
    answers = answer_rows(records, [method])
    return ReportTable(
        answers[~answers["solved"].astype(bool)].drop(columns=["method", "solved"]),
        "shortfalls",
        title="The exam: questions not solved",
        caption=f"Every question that {method} does not solve, by trial.",
    )
