"""How far forecasts are off: mean and spread of the error over the forecast's horizon."""

import numpy as np
import pandas as pd
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.patches import Patch

from pipeline.figures.style import FIGURE_WIDTH, INK, MUTED, predictor_colour

QUANTITIES = {
    "position": "position error (mm)",
    "velocity": "velocity error (m/s)",
    "spin": "spin error (rad/s)",
}
WINDOWS = {
    "all": "all windows",
    "with": "with a bounce",
    "without": "without a bounce",
}
DOTTED = (0, (1, 1.6))
HEADROOM = 1.15  # the number of windows stands over the lines


def forecast_error_figure(frame: pd.DataFrame) -> Figure:
    """Draw the error of every predictor on one set: quantities across, kinds of window down.

    A panel shows each predictor's mean error with its bootstrap interval, and dotted the standard
    deviation. Quantities and kinds of window that the set has not are left out.

    Args:
        frame: one row for each predictor, quantity and horizon of one set, with columns set,
            predictor, quantity ("position" mm, "velocity" m/s, "spin" rad/s), horizon_ms,
            bounce ("all", "with", "without"), mean, std, n, ci_low, ci_high.

    Raises:
        ValueError: if the frame does not hold exactly one set.
    """
    sets = frame["set"].unique()
    if len(sets) != 1:
        raise ValueError(f"one figure shows one set, but the frame holds {sorted(sets)}")
    quantities = [name for name in QUANTITIES if name in set(frame["quantity"])]
    windows = [name for name in WINDOWS if name in set(frame["bounce"])]
    predictors = sorted(frame["predictor"].unique())
    figure = Figure(figsize=(FIGURE_WIDTH, 1.4 + 1.8 * len(windows)))
    grid = figure.subplots(len(windows), len(quantities), sharex=True, sharey="col", squeeze=False)
    for axes_row, window in zip(grid, windows, strict=True):
        for axes, quantity in zip(axes_row, quantities, strict=True):
            rows = frame[(frame["quantity"] == quantity) & (frame["bounce"] == window)]
            _draw_panel(axes, rows, predictors)
        axes_row[0].set_title(WINDOWS[window])
    _label_axes(grid, quantities)
    _add_legends(figure, f"{sets[0]}: forecast error", predictors)
    return figure


def _draw_panel(axes: Axes, rows: pd.DataFrame, predictors: list[str]) -> None:
    for predictor in predictors:
        line = rows[rows["predictor"] == predictor].sort_values("horizon_ms")
        colour = predictor_colour(predictor)
        axes.fill_between(
            line["horizon_ms"], line["ci_low"], line["ci_high"], color=colour, alpha=0.22, lw=0
        )
        axes.plot(line["horizon_ms"], line["mean"], color=colour)
        axes.plot(line["horizon_ms"], line["std"], color=colour, lw=1.2, ls=DOTTED)
    fewest, most = rows["n"].min(), rows["n"].max()
    count = f"n = {most:,}" if fewest == most else f"n = {fewest:,} to {most:,}"
    note = axes.text(0.04, 0.97, count, transform=axes.transAxes, va="top", color=MUTED, fontsize=8)
    note.set_bbox({"color": "white", "pad": 1})


def _label_axes(grid: np.ndarray, quantities: list[str]) -> None:
    for axes_row in grid:
        for axes, quantity in zip(axes_row, quantities, strict=True):
            axes.set_ylabel(QUANTITIES[quantity])
    for axes in grid[0]:  # each stands for its column
        axes.set_ylim(0, HEADROOM * axes.get_ylim()[1])
    for axes in grid[-1]:
        axes.set_xlabel("forecast horizon (ms)")
        axes.set_xlim(100, 300)
        axes.set_xticks([100, 150, 200, 250, 300])


def _add_legends(figure: Figure, title: str, predictors: list[str]) -> None:
    lines = [Line2D([], [], color=predictor_colour(name), label=name) for name in predictors]
    key = [
        Line2D([], [], color=INK, label="mean"),
        Patch(color=MUTED, alpha=0.35, lw=0, label="its 95 % bootstrap interval"),
        Line2D([], [], color=INK, lw=1.2, ls=DOTTED, label="standard deviation"),
    ]
    figure.legend(
        handles=lines,
        loc="outside upper left",
        ncols=min(len(lines), 4),
        title=title,
        title_fontproperties={"size": 12, "weight": "bold"},
        alignment="left",
    )
    figure.legend(handles=key, loc="outside lower center", ncols=len(key))
