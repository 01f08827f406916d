"""Mean and standard deviation of the forecast error over the horizon."""

from typing import Literal

import numpy as np
import pandas as pd
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.patches import Patch

from rallygap.pipeline.web.figure_style import (
    FIGURE_WIDTH,
    MUTED,
    predictor_colour,
    predictor_order,
)
from rallygap.pipeline.web.labels import predictor_label

Dashes = Literal["solid", "dashed", "dotted"]

QUANTITIES = {
    "position": "position error (mm)",
    "velocity": "velocity error (m/s)",
    "spin": "spin error (rad/s)",
}
# Rows of panels: title to windows and statistic. Means share one scale.
ROWS = {
    "mean, all windows": ("all", "mean"),
    "standard deviation, all windows": ("all", "std"),
    "mean, with a bounce": ("with", "mean"),
    "mean, without a bounce": ("without", "mean"),
}
HEADROOM = 0.15  # share of the panel above the lines, for the number of windows
LEGEND_COLUMNS = 3
FINE_TUNED, AMENDED = "_fine_tuned", "amended_"  # in predictors' names
# More bands than these would hide one another.
WITH_BANDS = ("physics_c", "hybrid", "transformer", "amended_imperfect_c")


def forecast_error_figure(frame: pd.DataFrame) -> Figure:
    """Draw the error of every predictor on one set: columns are quantities, rows kinds of window.

    A panel shows each predictor's mean error with its bootstrap interval, or its standard
    deviation. Quantities and kinds of window without data are left out.

    Args:
        frame: one row for each predictor, quantity and horizon of one set, with columns set,
            predictor, quantity ("position" mm, "velocity" m/s, "spin" rad/s), horizon_ms,
            bounce ("all", "with", "without"), mean, std, n, ci_low, ci_high.
    """
    quantities = [name for name in QUANTITIES if name in set(frame["quantity"])]
    titles = [title for title, (window, _) in ROWS.items() if window in set(frame["bounce"])]
    predictors = sorted(frame["predictor"].unique(), key=predictor_order)
    figure = Figure(figsize=(FIGURE_WIDTH, 1.4 + 1.8 * len(titles)))
    grid = figure.subplots(len(titles), len(quantities), sharex=True, squeeze=False)
    for axes_row, title in zip(grid, titles, strict=True):
        window, statistic = ROWS[title]
        for axes, top, quantity in zip(axes_row, grid[0], quantities, strict=True):
            if statistic == "mean" and axes is not top:
                axes.sharey(top)
            rows = frame[(frame["quantity"] == quantity) & (frame["bounce"] == window)]
            _draw_panel(axes, rows, statistic, predictors)
        axes_row[0].set_title(title)
    _label_axes(grid, quantities)
    _add_legends(figure, f"{frame['set'].iloc[0]}: forecast error", predictors)
    return figure


def _draw_panel(axes: Axes, rows: pd.DataFrame, statistic: str, predictors: list[str]) -> None:
    for predictor in predictors:
        line = rows[rows["predictor"] == predictor].sort_values("horizon_ms")
        colour, dashes = line_style(predictor)
        if statistic == "mean" and predictor in WITH_BANDS:
            low, high = line["ci_low"], line["ci_high"]
            axes.fill_between(line["horizon_ms"], low, high, color=colour, alpha=0.22, lw=0)
        axes.plot(line["horizon_ms"], line[statistic], color=colour, linestyle=dashes)
    counts = sorted({rows["n"].min(), rows["n"].max()}) if len(rows) else [0]
    count = "n = " + " to ".join(f"{number:,}" for number in counts)
    note = axes.text(0.04, 0.97, count, transform=axes.transAxes, va="top", color=MUTED, fontsize=8)
    note.set_bbox({"color": "white", "pad": 1})


def line_style(predictor: str) -> tuple[str, Dashes]:
    """Return colour and dashes: fine-tuned is dashed, in its network's colour; amended dotted."""
    network = predictor.removesuffix(FINE_TUNED)
    dashes: Dashes = "dotted" if predictor.startswith(AMENDED) else "solid"
    if network != predictor:
        dashes = "dashed"
    return predictor_colour(network), dashes


def _label_axes(grid: np.ndarray, quantities: list[str]) -> None:
    for axes_row in grid:
        for axes, quantity in zip(axes_row, quantities, strict=True):
            axes.set_ylabel(QUANTITIES[quantity])
            axes.margins(y=HEADROOM)
            axes.set_ylim(bottom=0)
    for axes in grid[-1]:
        axes.set_xlabel("forecast horizon (ms)")
        axes.set_xlim(100, 300)
        axes.set_xticks([100, 150, 200, 250, 300])


def _add_legends(figure: Figure, title: str, predictors: list[str]) -> None:
    styles = {name: line_style(name) for name in predictors}
    lines = [
        Line2D([], [], color=colour, linestyle=dashes, label=predictor_label(name))
        for name, (colour, dashes) in styles.items()
    ]
    figure.legend(
        handles=lines,
        loc="outside upper left",
        ncols=min(len(lines), LEGEND_COLUMNS),
        title=title,
        title_fontproperties={"size": 12, "weight": "bold"},
        alignment="left",
    )
    label = "95 % bootstrap interval of the mean; all intervals are in the tables"
    interval = Patch(color=MUTED, alpha=0.35, lw=0, label=label)
    figure.legend(handles=[interval], loc="outside lower center")
