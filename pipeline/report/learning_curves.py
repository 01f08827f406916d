"""Figure of the learning curves."""

from collections.abc import Iterator

import pandas as pd
from matplotlib.figure import Figure
from matplotlib.ticker import FixedLocator, NullLocator

from rallygap.pipeline.runtime.stage_run import StageRun
from rallygap.pipeline.web.figure_style import FIGURE_WIDTH, predictor_colour
from rallygap.pipeline.web.report_items import ReportFigure, ReportItem

TICKS_MM = (10, 20, 30, 50, 100, 200)
LABELS = {
    "oracle": "oracle: the true physics",
    "amended_imperfect_c": "simulator C, amended",
    "hybrid": "hybrid: network on simulator C with a net",
    "transformer": "transformer",
}


def items(run: StageRun) -> Iterator[ReportItem]:
    """Yield position errors over the number of recordings."""
    yield ReportFigure(
        learning_curves_figure(run.published("learning_curves", "errors")),
        "errors",
        title="Errors by the number of training recordings",
        caption="Mean position error on the arena's test windows, with 95 % intervals over draws "
        "and test recordings.",
    )


def learning_curves_figure(rows: pd.DataFrame) -> Figure:
    """Draw position errors over the number of training recordings, a panel a horizon.

    Args:
        rows: of ``curve_rows``.
    """
    horizons = sorted(rows["horizon_ms"].unique())
    sizes = sorted(rows["recordings"].unique())
    figure = Figure(figsize=(FIGURE_WIDTH, 3.6))
    grid = figure.subplots(1, len(horizons), sharex=True, sharey=True, squeeze=False)[0]
    for axes, horizon in zip(grid, horizons, strict=True):
        for predictor, label in LABELS.items():
            line = rows.query("predictor == @predictor and horizon_ms == @horizon")
            colour = predictor_colour(predictor)
            axes.fill_between(
                line["recordings"], line["ci_low"], line["ci_high"], color=colour, alpha=0.2, lw=0
            )
            axes.plot(
                line["recordings"], line["mean"], color=colour,
                marker="o", markersize=3, label=label,
            )  # fmt: skip
        axes.set_xscale("log")
        axes.set_yscale("log")
        axes.xaxis.set_major_locator(FixedLocator(sizes))
        axes.xaxis.set_minor_locator(NullLocator())
        axes.set_xticks(sizes, [f"{size:,}" for size in sizes])
        axes.yaxis.set_major_locator(FixedLocator(TICKS_MM))
        axes.yaxis.set_major_formatter("{x:g}")
        axes.yaxis.set_minor_locator(NullLocator())
        axes.set_title(f"{horizon} ms ahead")
        axes.set_xlabel("training recordings")
    grid[0].set_ylabel("position error (mm)")
    handles, labels = grid[0].get_legend_handles_labels()
    figure.legend(handles, labels, loc="outside lower center", ncols=2)
    return figure
