"""The report of `retrain_policy`: return rates before and after, and parameters."""

from collections.abc import Iterator

import pandas as pd
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from rallygap.pipeline.report.plots import (
    WHISKERS,
    ahead,
    label_rows,
    percent,
    physics_colour,
    sample,
)
from rallygap.pipeline.runtime.stage_run import StageRun
from rallygap.pipeline.web.figure_style import FIGURE_WIDTH, MUTED
from rallygap.pipeline.web.labels import predictor_label
from rallygap.pipeline.web.report_items import ReportFigure, ReportItem, ReportTable


def items(run: StageRun) -> Iterator[ReportItem]:
    """Yield return rates on the same shots, in policies' own simulators, and parameters."""
    settings, returns = run.params.sim2real, run.kept("retrain_policy", "returns")
    caption = (
        f"The policies of {settings.group} from {settings.simulator}, and the same policies "
        "retrained in the simulator amended from training shots of the source, with the same "
        "goals, horizons, seeds and training iterations. All play the shots of sim2real, with "
        "forecasts at every control step."
    )
    yield ReportFigure(
        retraining_figure(returns[returns["set"].isin(run.params.retrain_policy.sources)]),
        "returns",
        title="Retraining: return rates on the same shots",
        caption=caption,
    )
    yield ReportTable(
        returns,
        "returns",
        title="Retraining: share of the gap in returns that each change closes",
        caption=f"{caption} original, physics: the baseline; original with a learned "
        "predictor: the swap; original, amended: the amended simulator predicts; retrained, "
        "amended; and both, retrained with a learned predictor. Rates with 95 % intervals "
        "(low, high) over trainings and recordings. difference: of the return "
        "rate to the baseline's, paired by shot (ci_low, ci_high); gained, lost: shots "
        "returned more often, or less. gap_closed: that difference as a share of the gap "
        "between the baseline and the original policy with the oracle, or without an oracle "
        "its return rate in its own simulator; empty without a significant gap.",
    )
    yield ReportTable(
        run.kept("retrain_policy", "own_simulator"),
        "own_simulator",
        title="Policies in their own simulators",
        caption="Each policy plays test shots of the simulator that it was trained in, with "
        "exact forecasts; original and retrained policies play as many. 95 % intervals are "
        "over trainings and shots.",
    )
    yield ReportTable(
        run.kept("retrain_policy", "numbers"),
        "numbers",
        title="Simulator parameters before and after",
        caption=f"Parameters of {settings.simulator} that were amended from shots of the source, "
        "or that differ from the truth; empty where a simulator lacks the effect. low, high: 95 % "
        "interval of amended parameters. The truth is known for the arena only, and hidden "
        "from close_gap.",
    )


def retraining_figure(table: pd.DataFrame) -> Figure:
    """Draw return rates by policy and predictor: a column per set, a row per triple of horizons.

    Args:
        table: one row per ``set``, ``horizons_ms``, ``policy`` and ``predictor``, with ``balls``,
            ``trainings``, ``return_rate``, ``return_rate_low`` and ``return_rate_high``.
    """
    sets, horizons = list(table["set"].unique()), list(table["horizons_ms"].unique())
    bars = len(table[["policy", "predictor"]].drop_duplicates())
    figure = Figure(figsize=(FIGURE_WIDTH, len(horizons) * (1.0 + 0.3 * bars)))
    grid = figure.subplots(len(horizons), len(sets), sharex=True, squeeze=False)
    for panels, label in zip(grid, horizons, strict=True):
        for axes, name in zip(panels, sets, strict=True):
            rows = table[(table["set"] == name) & (table["horizons_ms"] == label)]
            _draw_panel(axes, rows)
            axes.set_title(f"{name}, horizons {ahead(label)}, {sample(rows)}")
    for axes in grid[-1]:
        axes.set_xlabel("return rate (%)")
    return figure


def _draw_panel(axes: Axes, rows: pd.DataFrame) -> None:
    rate, ends = percent(rows)
    predictors = rows["predictor"].map(predictor_label)
    colours = rows["predictor"].map(physics_colour)
    axes.barh(range(len(rows)), rate, 0.7, color=colours, xerr=ends, error_kw=WHISKERS)
    label_rows(axes, list(rows["policy"] + " policy, " + predictors))
    axes.set_xlim(0, 100)
    axes.grid(visible=False, axis="y")
    axes.axvline(rate.iloc[0], color=MUTED, lw=0.9, ls="--")
