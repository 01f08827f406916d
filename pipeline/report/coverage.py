"""Coverage and size of the prediction regions of positions over the horizon."""

import pandas as pd
from matplotlib.figure import Figure
from matplotlib.lines import Line2D

from rallygap.pipeline.report.forecast_error import (
    FINE_TUNED,
    LEGEND_COLUMNS,
    line_style,
)
from rallygap.pipeline.web.figure_style import FIGURE_WIDTH, MUTED, predictor_order
from rallygap.pipeline.web.labels import predictor_label

HEIGHT = 5.5  # inches
EVERY_MS = 25
# More lines than these, and fine-tuned ones, would hide one another; the table has all predictors.
SHOWN = ("physics_c", "oracle", "hybrid", "transformer", "amended_imperfect_c")


def coverage_figure(rows: pd.DataFrame) -> Figure:
    """Draw a column of panels for each level: coverage above, size below, every 25 ms.

    Args:
        rows: of one set, with columns predictor, level, horizon_ms, coverage, size_mm. Of the
            predictors, ``SHOWN`` are drawn, also fine-tuned, or all if the set has none of them.
    """
    rows = rows[rows["horizon_ms"] % EVERY_MS == 0]
    levels = sorted(rows["level"].unique())
    every = sorted(rows["predictor"].unique(), key=predictor_order)
    predictors = [name for name in every if name.removesuffix(FINE_TUNED) in SHOWN] or every
    figure = Figure(figsize=(FIGURE_WIDTH, HEIGHT))
    grid = figure.subplots(2, len(levels), sharex=True, squeeze=False)
    for (above, below), level in zip(grid.T, levels, strict=True):
        for name in predictors:
            line = rows[(rows["predictor"] == name) & (rows["level"] == level)]
            colour, dashes = line_style(name)
            style = {"color": colour, "linestyle": dashes}
            above.plot(line["horizon_ms"], 100 * line["coverage"], **style)
            below.plot(line["horizon_ms"], line["size_mm"], **style)
        above.axhline(100 * level, color=MUTED, linestyle="dotted")
        above.set_title(f"regions of {100 * level:.0f} %")
        below.set_xlabel("forecast horizon (ms)")
        below.set_ylim(bottom=0)
    grid[0, 0].set_ylabel("coverage (%)")
    grid[1, 0].set_ylabel("radius (mm)")
    lines = [
        Line2D(
            [],
            [],
            color=line_style(name)[0],
            linestyle=line_style(name)[1],
            label=predictor_label(name),
        )
        for name in predictors
    ]
    figure.legend(handles=lines, loc="outside upper left", ncols=min(len(lines), LEGEND_COLUMNS))
    return figure
