"""Figure of return rates by what policies learn from and observe."""

from collections.abc import Iterator

import pandas as pd
from matplotlib.figure import Figure

from rallygap.pipeline.runtime.stage_run import StageRun
from rallygap.pipeline.web.figure_style import FIGURE_WIDTH, MUTED
from rallygap.pipeline.web.labels import predictor_label
from rallygap.pipeline.web.report_items import ReportFigure, ReportItem

LABELS = {
    "exact": "learned from exact forecasts",
    "filtered": "learned from a filter's forecasts",
    "filtered_with_spread": "observes their spread, too",
}
ROW, HEADROOM = 0.22, 1.4  # inch per predictor and policy, and for title and axis
APART = 0.25  # of the policies with one predictor
MARKERS = ("o", "s", "D")
COLOURS = (MUTED, "#0f7fc4", "#d55e00")


def items(run: StageRun) -> Iterator[ReportItem]:
    """Yield return rates of policies that observe spreads, and of others."""
    yield ReportFigure(
        spread_policies_figure(run.published("spread_policies", "rates")),
        "rates",
        title="Policies that observe how sure forecasts are",
        caption="Return rates on the shots of sim2real, with 95 % intervals over trainings and "
        "recordings.",
    )


def spread_policies_figure(table: pd.DataFrame) -> Figure:
    """Draw return rates with their intervals: a column per set, a row per predictor.

    Args:
        table: one row per ``set``, ``predictor`` and ``policy``, with ``balls``, ``return_rate``,
            ``return_rate_low`` and ``return_rate_high``.
    """
    sets, predictors = list(table["set"].unique()), list(table["predictor"].unique())
    height = HEADROOM + ROW * len(predictors) * len(LABELS)
    figure = Figure(figsize=(FIGURE_WIDTH, height))
    grid = figure.subplots(1, len(sets), sharex=True, sharey=True, squeeze=False)[0]
    for axes, name in zip(grid, sets, strict=True):
        of_set = table[table["set"] == name]
        for number, (policy, label) in enumerate(LABELS.items()):
            rows = of_set[of_set["policy"] == policy]
            rate = 100 * rows["return_rate"]
            places = [predictors.index(one) + APART * (number - 1) for one in rows["predictor"]]
            axes.errorbar(
                rate,
                places,
                xerr=[rate - 100 * rows["return_rate_low"], 100 * rows["return_rate_high"] - rate],
                fmt=MARKERS[number],
                color=COLOURS[number],
                markersize=4,
                capsize=2,
                label=label,
            )
        axes.set_title(f"{name}, n = {of_set['balls'].iloc[0]}")
        axes.set_xlabel("return rate (%)")
        axes.set_ylim(len(predictors) - 0.5, -0.5)
        axes.grid(visible=False, axis="y")
    grid[0].set_yticks(range(len(predictors)), [predictor_label(one) for one in predictors])
    handles, labels = grid[0].get_legend_handles_labels()
    figure.legend(handles, labels, loc="outside lower center", ncols=3)
    return figure
