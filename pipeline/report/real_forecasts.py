"""Figure of the forecasts of measured sets."""

from collections.abc import Iterator

import pandas as pd
from matplotlib.figure import Figure

from rallygap.pipeline.runtime.stage_run import StageRun
from rallygap.pipeline.web.figure_style import FIGURE_WIDTH
from rallygap.pipeline.web.report_items import ReportFigure, ReportItem

# Predictors that recordings of a measured set have amended or fine-tuned.
ADAPTED = {
    "physics_literature": "physics, literature",
    "amended": "physics, literature amended",
    "hybrid": "hybrid on the amended simulator",
    "transformer": "transformer",
    "transformer_ensemble": "ensemble of two transformers",
    "hybrid_ensemble": "ensemble of hybrid and transformer",
}
HORIZONS = {100: ("o", "#8fc4e8"), 200: ("s", "#0f7fc4"), 300: ("D", "#0a3f66")}


def items(run: StageRun) -> Iterator[ReportItem]:
    """Yield position errors on measured sets."""
    yield ReportFigure(
        real_forecasts_figure(run.published("real_forecasts", "errors")),
        "errors",
        title="Forecast errors on measured sets",
        caption="Mean position error by cross-validation over recordings, with 95 % intervals "
        "bootstrapped over recordings.",
    )


def real_forecasts_figure(rows: pd.DataFrame) -> Figure:
    """Draw position errors with their intervals: a panel a set, a row a predictor.

    Args:
        rows: ``set``, ``predictor``, ``quantity``, ``bounce``, ``horizon_ms``, ``mean``, ``ci_low``
            and ``ci_high`` in mm, and ``n``.
    """
    shown = rows[(rows["quantity"] == "position") & (rows["bounce"] == "all")]
    sets, names = list(shown["set"].unique()), list(ADAPTED)
    figure = Figure(figsize=(FIGURE_WIDTH, 3.0))
    grid = figure.subplots(1, len(sets), sharey=True, squeeze=False)[0]
    for axes, name in zip(grid, sets, strict=True):
        of_set = shown[shown["set"] == name]
        for horizon, (marker, colour) in HORIZONS.items():
            some = of_set[of_set["horizon_ms"] == horizon].set_index("predictor").loc[names]
            ends = [some["mean"] - some["ci_low"], some["ci_high"] - some["mean"]]
            axes.errorbar(
                some["mean"], range(len(names)), xerr=ends, fmt=marker, color=colour,
                markersize=4, capsize=2, label=f"{horizon} ms ahead",
            )  # fmt: skip
        axes.set_title(name)
        axes.set_xlim(left=0)
        axes.set_xlabel("position error (mm)")
        axes.grid(visible=False, axis="y")
    grid[0].set_yticks(range(len(names)), [ADAPTED[one].removeprefix("physics, ") for one in names])
    grid[0].set_ylim(len(names) - 0.5, -0.5)
    handles, labels = grid[0].get_legend_handles_labels()
    figure.legend(handles, labels, loc="outside lower center", ncols=3)
    return figure
