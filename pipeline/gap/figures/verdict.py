"""A verdict in pictures: the causes, and how far the gap closes."""

from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from models.gap.verdict import Cause, Gap, Verdict
from pipeline.gap.wording import label, number, with_unit
from pipeline.io.figure_style import FIGURE_WIDTH, INK, MUTED

KIND_COLOURS = {"wrong_value": "#0f7fc4", "missing_effect": "#d55e00"}
KIND_NAMES = {"wrong_value": "wrong value", "missing_effect": "missing effect"}
LINES = {
    "before": ("#d55e00", "-", "o"),
    "after": ("#0f7fc4", "-", "s"),
    "floor": (MUTED, "--", ""),
}
LINE_NAMES = {
    "before": "the simulator as it was",
    "after": "amended",
    "floor": "without any gap",
}
HIDDEN = "#e9edf0"  # what the shots might not show
BAND = 0.15  # opacity of intervals
ROW_HEIGHT = 0.55  # inch
HEADROOM = 1.1  # inch, for the axis and the legend
DETECTABLE = 5.8 / 1.96  # half-widths of a 95 % interval that are found almost surely
_OFFSET: dict[str, Any] = {"textcoords": "offset points"}


def causes_figure(verdict: Verdict) -> Figure:
    """Draw how far every cause lies from the simulator, in sizes that shots show almost surely.

    Args:
        verdict: with at least one cause.

    Raises:
        ValueError: it has no cause.
    """
    if not verdict.effects:
        raise ValueError("a verdict without causes has nothing to draw")
    rows = len(verdict.effects)
    figure = Figure(figsize=(FIGURE_WIDTH, HEADROOM + ROW_HEIGHT * rows))
    axes = figure.subplots()
    axes.axvspan(-1, 1, color=HIDDEN, lw=0, label="might stay hidden")
    axes.axvline(0, color=INK, lw=1)
    for row, cause in enumerate(verdict.effects):
        _draw_cause(axes, row, cause)
    axes.set_yticks(range(rows), [label(one) for one in verdict.effects])
    axes.set_ylim(rows - 0.5, -0.5)
    axes.margins(x=0.3)
    axes.grid(axis="y", visible=False)
    axes.set_xlabel("departure from the simulator, in smallest detectable sizes")
    handles, names = axes.get_legend_handles_labels()
    unique = dict(zip(names, handles, strict=True))
    figure.legend(unique.values(), unique.keys(), loc="outside upper left", ncols=3)
    return figure


def error_figure(gap: Gap) -> Figure:
    """Draw the error over the horizon: as it was, amended, and with no gap left."""
    figure = Figure(figsize=(FIGURE_WIDTH, 3.6))
    axes = figure.subplots()
    draw_errors(axes, gap)
    axes.set_ylim(bottom=0)
    axes.set_xlabel("prediction horizon (ms)")
    axes.set_ylabel("position error (mm)")
    figure.legend(loc="outside upper left", ncols=3)
    return figure


def draw_errors(axes: Axes, gap: Gap) -> None:
    """Draw errors over the horizon, with 95 % bands of those that shots measure."""
    for name, (colour, line, marker) in LINES.items():
        values = getattr(gap, f"{name}_mm")
        axes.plot(
            gap.horizons_ms, values, line + marker, color=colour, label=LINE_NAMES[name], ms=4
        )
    for name in ("before", "after"):
        low, high = np.transpose(getattr(gap, f"{name}_interval_mm"))
        axes.fill_between(gap.horizons_ms, low, high, color=LINES[name][0], alpha=BAND, lw=0)


def draw_departure(axes: Axes, row: float, cause: Cause, line: float, mark: float) -> float:
    """Draw how far a cause lies from the simulator's value, with its interval; return its high end.

    Args:
        axes: whose x counts detectable sizes.
        row: on y.
        cause: of the gap.
        line: width of the interval's, points.
        mark: size of the estimate's, points.
    """
    size = DETECTABLE * (cause.interval[1] - cause.interval[0]) / 2
    low, middle, high = (
        (value - cause.nominal) / size
        for value in (cause.interval[0], cause.estimate, cause.interval[1])
    )
    colour = KIND_COLOURS[cause.kind]
    axes.plot([low, high], [row, row], color=colour, lw=line, solid_capstyle="butt")
    axes.plot(middle, row, "o", color=colour, ms=mark, label=KIND_NAMES[cause.kind])
    return high


def _draw_cause(axes: Axes, row: int, cause: Cause) -> None:
    high = draw_departure(axes, row, cause, line=3, mark=7)
    text = f"{with_unit(cause.estimate, cause.unit)}, simulator {number(cause.nominal)}"
    axes.annotate(text, (high, row), (8, 0), va="center", fontsize=8, color=MUTED, **_OFFSET)
