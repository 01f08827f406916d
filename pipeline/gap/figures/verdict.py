"""Figures of one verdict: its causes, and prediction errors before and after."""

from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from rallygap.models.gap.verdict import Cause, Gap, Verdict
from rallygap.pipeline.web.figure_style import FIGURE_WIDTH, INK, MUTED
from rallygap.pipeline.web.numbers import number, with_unit
from rallygap.pipeline.web.report_items import ReportFigure

KIND_COLOURS = {"wrong_value": "#0f7fc4", "missing_effect": "#d55e00"}
KIND_NAMES = {"wrong_value": "wrong value", "missing_effect": "missing effect"}
LINES = {
    "before": ("#d55e00", "-", "o"),
    "after": ("#0f7fc4", "-", "s"),
    "floor": (MUTED, "--", ""),
}
LINE_NAMES = {
    "before": "nominal simulator",
    "after": "amended simulator",
    "floor": "prediction floor",
}
HIDDEN = "#e9edf0"  # departures below the minimum detectable effect
BELOW_MINIMUM = "below the minimum detectable effect"
BAND = 0.15  # opacity of intervals
ROW_HEIGHT = 0.55  # inch
HEADROOM = 1.1  # inch, for the axis and the legend


def causes_figure(verdict: Verdict) -> ReportFigure:
    """Draw the departure of every main cause from the nominal simulator; there is at least one."""
    rows = len(verdict.main_causes)
    figure = Figure(figsize=(FIGURE_WIDTH, HEADROOM + ROW_HEIGHT * rows))
    axes = figure.subplots()
    shade_undetectable(axes)
    for row, cause in enumerate(verdict.main_causes):
        _draw_cause(axes, row, cause, verdict)
    axes.set_yticks(range(rows), [cause.identity for cause in verdict.main_causes])
    axes.set_ylim(rows - 0.5, -0.5)
    axes.margins(x=0.3)
    axes.grid(axis="y", visible=False)
    axes.set_xlabel("estimate − simulator, in minimum detectable effects (5.8 σ)")
    add_legend(figure)
    return ReportFigure(
        figure,
        "causes",
        title="Estimated causes",
        caption="Estimate and 95 % interval of leading causes and sensor faults, less the "
        "simulator's value, in minimum detectable effects (5.8 standard errors with the "
        "simulator's own parameters free). Effects in the shaded band may not be detected.",
    )


def error_figure(gap: Gap) -> ReportFigure:
    """Draw the prediction error over the horizon: before, after and the floor."""
    figure = Figure(figsize=(FIGURE_WIDTH, 3.6))
    axes = figure.subplots()
    draw_errors(axes, gap)
    axes.set_ylim(bottom=0)
    axes.set_xlabel("prediction horizon (ms)")
    axes.set_ylabel("position error (mm)")
    figure.legend(loc="outside upper left", ncols=3)
    return ReportFigure(
        figure,
        "errors",
        title="Prediction error over the horizon",
        caption="Root mean square error on held-out shots, each predicted from its first twelve "
        "samples, with the nominal and the amended simulator. Bands: 95 %, bootstrap over shots. "
        "Prediction floor: error of a correct simulator with the same noise and bounce scatter.",
    )


def add_legend(figure: Figure) -> None:
    """Add the legend of all panels above them, each label once."""
    legends = [zip(*axes.get_legend_handles_labels(), strict=True) for axes in figure.axes]
    unique = {name: handle for legend in legends for handle, name in legend}
    figure.legend(unique.values(), unique.keys(), loc="outside upper left", ncols=3)


def draw_errors(axes: Axes, gap: Gap) -> None:
    """Draw errors over the horizon, with 95 % bands of the measured ones."""
    for name, (colour, line, marker) in LINES.items():
        values = getattr(gap, f"{name}_mm")
        axes.plot(
            gap.horizons_ms, values, line + marker, color=colour, label=LINE_NAMES[name], ms=4
        )
    for name in ("before", "after"):
        low, high = np.transpose(getattr(gap, f"{name}_interval_mm"))
        axes.fill_between(gap.horizons_ms, low, high, color=LINES[name][0], alpha=BAND, lw=0)


def shade_undetectable(axes: Axes) -> None:
    """Shade departures below the minimum detectable effect, and mark the nominal value."""
    axes.axvspan(-1, 1, color=HIDDEN, lw=0, label=BELOW_MINIMUM)
    axes.axvline(0, color=INK, lw=1)


def draw_departure(
    axes: Axes, row: float, cause: Cause, verdict: Verdict, *, line: float, mark: float
) -> float | None:
    """Draw the departure of a cause with its interval; return the interval's upper end.

    A cause that is not identifiable with the simulator's own parameters free has no minimum
    detectable effect; nothing is drawn, and None returned. The widths of the interval's line and of
    the estimate's mark are in points.
    """
    size = verdict.minimum_detectable.get(cause.identity)
    if size is None:
        return None
    low, middle, high = (
        (value - cause.nominal) / size
        for value in (cause.interval[0], cause.estimate, cause.interval[1])
    )
    colour = KIND_COLOURS[cause.kind]
    axes.plot([low, high], [row, row], color=colour, lw=line, solid_capstyle="butt")
    axes.plot(middle, row, "o", color=colour, ms=mark, label=KIND_NAMES[cause.kind])
    return high


def _draw_cause(axes: Axes, row: int, cause: Cause, verdict: Verdict) -> None:
    high = draw_departure(axes, row, cause, verdict, line=3, mark=7)
    text = f"{with_unit(cause.estimate, cause.unit)}, simulator {number(cause.nominal)}"
    if high is None:
        text, high = f"{text}; no minimum detectable effect", 0.0
    style: dict[str, Any] = {"textcoords": "offset points", "va": "center", "fontsize": 8}
    axes.annotate(text, (high, row), (8, 0), color=MUTED, **style)
