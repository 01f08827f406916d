"""Figures of one method: confusion matrix, and coverage of confidence intervals."""

from collections import Counter
from collections.abc import Sequence

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from rallygap.models.ball.types import Floats
from rallygap.models.exam.records import AnswerRecord, ExamRecord
from rallygap.models.exam.scoring.rates import answered, covered, interval, of_base, of_group
from rallygap.pipeline.web.figure_style import FIGURE_WIDTH, INK, MUTED
from rallygap.pipeline.web.report_items import ReportFigure

OTHERS = ("no gap", "unknown", "several", "failed")  # answers other than one cause
NOTHING = "nothing"
TARGET = (0.93, 0.97)  # of the coverage of a 95 % interval
COLOUR = "#0f7fc4"


def confusion_figure(records: Sequence[ExamRecord], method: str) -> ReportFigure:
    """Return the confusion matrix of a method at 3 detection limits, with clean sets below."""
    given = answered([*of_base(records), *of_group(records, "clean")], method)
    counts = Counter((_hidden(record), _named(record.answers[method])) for record in given)
    parameters = sorted({record.parameters[0] for record in of_base(records)})
    rows = [*parameters, NOTHING]
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
    return record.parameters[0] if record.hidden else NOTHING


def _named(answer: AnswerRecord) -> str:
    if answer.conclusion in (None, "no_gap", "unknown"):
        return {None: "failed", "no_gap": "no gap", "unknown": "unknown"}[answer.conclusion]
    return answer.causes[0].identity if len(answer.causes) == 1 else "several"


def coverage_figure(records: Sequence[ExamRecord], method: str) -> ReportFigure:
    """Return how often 95 % intervals contain the true value, by group of questions."""
    groups: dict[str, list[ExamRecord]] = {}
    for record in records:
        name = f"{record.group} {record.cell}".strip().replace("_", " ")
        groups.setdefault(name, []).append(record)
    contains = {name: covered(some, method) for name, some in groups.items()}
    contains = {"all": [one for some in contains.values() for one in some], **contains}
    shown = {f"{name} ({len(some)})": some for name, some in contains.items() if some}
    figure = Figure(figsize=(FIGURE_WIDTH, 1.2 + 0.22 * max(len(shown), 1)))
    axes = figure.subplots()
    axes.axvspan(100 * TARGET[0], 100 * TARGET[1], color="#dfe9f2", lw=0)
    for place, some in enumerate(shown.values()):
        low, high = interval(sum(some), len(some))
        share = 100 * sum(some) / len(some)
        axes.plot([100 * low, 100 * high], [place, place], color=COLOUR)
        axes.plot(share, place, "o", ms=4, color=COLOUR)
    axes.set_yticks(range(len(shown)), list(shown))
    axes.invert_yaxis()
    axes.set(xlabel="intervals that contain the true value (%)")
    return ReportFigure(
        figure,
        "coverage",
        title="Coverage of 95 % intervals",
        caption=f"Correctly named parameters of {method} at 3 detection limits or more (number in "
        "brackets): share whose interval contains the true value, with its 95 % interval. The "
        f"band is {100 * TARGET[0]:.0f} to {100 * TARGET[1]:.0f} %.",
    )
