"""What the exam shows of one method: what it takes for what, and whether its intervals hold."""

from collections import Counter
from collections.abc import Sequence

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from models.ball.types import Floats
from models.exam.record import Answered, Sheet
from models.exam.scoring.rates import at_3x, covered, interval, of_group, posed
from pipeline.io.figure_style import FIGURE_WIDTH, INK, MUTED

OTHERS = ("no gap", "unknown", "several", "failed")  # answers that are no single name
NOTHING = "nothing"
TARGET = (0.93, 0.97)  # of the coverage of a 95 % interval
COLOUR = "#0f7fc4"


def confusion_figure(sheets: Sequence[Sheet], method: str) -> Figure:
    """Draw what was hidden against what was named: the sweeps' base, and the clean sets below.

    Args:
        sheets: of the exam.
        method: whose answers count.
    """
    asked = posed([*at_3x(sheets), *of_group(sheets, "clean")], method)
    counts = Counter((_hidden(one), _named(one.answers[method])) for one in asked)
    numbers = sorted({one.asked[0] for one in at_3x(sheets)})
    rows = [*numbers, NOTHING]
    others = sorted({column for _, column in counts} - {*numbers, *OTHERS})
    columns = [*numbers, *others, *OTHERS]
    table = np.array([[counts[row, column] for column in columns] for row in rows], dtype=float)
    figure = Figure(figsize=(FIGURE_WIDTH, 1.2 + 0.185 * len(rows)))
    _draw_shares(figure.subplots(), table, rows, columns)
    return figure


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
    axes.set(ylabel="hidden (trials)", xlabel="answered, % of the trials")
    axes.axhline(len(rows) - 1.5, color=MUTED, lw=0.8)
    axes.axvline(len(columns) - len(OTHERS) - 0.5, color=MUTED, lw=0.8)
    axes.grid(visible=False)


def _hidden(sheet: Sheet) -> str:
    return sheet.asked[0] if sheet.hidden else NOTHING


def _named(given: Answered) -> str:
    if given.answer in (None, "no_gap", "unknown"):
        return {None: "failed", "no_gap": "no gap", "unknown": "unknown"}[given.answer]
    if len(given.causes) != 1:
        return "several"
    return f"{given.causes[0].effect}.{given.causes[0].parameter}"


def coverage_figure(sheets: Sequence[Sheet], method: str) -> Figure:
    """Draw how often 95 % intervals hold the truth, by group of questions.

    Args:
        sheets: of the exam.
        method: whose intervals count.
    """
    kinds = list(dict.fromkeys((one.group, one.cell) for one in sheets))
    held = {
        " ".join(part for part in kind if part): covered(
            [one for one in sheets if (one.group, one.cell) == kind], method
        )
        for kind in kinds
    }
    held = {"all": [one for some in held.values() for one in some], **held}
    shown = {f"{name} ({len(some)})": some for name, some in held.items() if some}
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
    axes.set(xlabel="intervals that hold the truth (%)")
    return figure
