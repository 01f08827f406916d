"""The report of `sim2sim`: return rates in the form of the paper's figure, and tables."""

from collections.abc import Iterator
from typing import Any

import numpy as np
import pandas as pd
from matplotlib.artist import Artist
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.patches import Patch

from rallygap.pipeline.report.plots import ahead, percent, sample
from rallygap.pipeline.runtime.stage_run import StageRun
from rallygap.pipeline.transfer.trials import GROUND_TRUTH, IMPERFECT
from rallygap.pipeline.web.figure_style import FIGURE_WIDTH, INK
from rallygap.pipeline.web.labels import simulator_label
from rallygap.pipeline.web.report_items import ReportFigure, ReportItem, ReportTable

# Label, colour, and side on which the bar is of its simulator's place.
PREDICTORS = {
    GROUND_TRUTH: ("the ground truth", "#0f7fc4", -0.5),
    IMPERFECT: ("the policy's own simulator", "#d55e00", 0.5),
}
# What predictions start from.
PROTOCOLS = {
    "first_state": "one prediction from the ball's first state, as in the paper",
    "re_anchored": "a new prediction at every control step, from the ball's true state",
}
# Single policies, drawn next to the whisker of a bar.
DOTS: dict[str, Any] = {"ls": "", "marker": "o", "ms": 4, "mfc": "white", "mec": INK, "mew": 0.8}
BAR = 0.38  # width; simulators are 1 apart
GAP = 0.5  # more between the horizons
COLUMNS = ["protocol", "simulator", "horizons_ms", "predictor"]
COLUMNS += ["return_rate", "std", "ci_low", "ci_high", "hit_rate", "forecast_error_m"]


def items(run: StageRun) -> Iterator[ReportItem]:
    """Yield the figure of return rates, and the tables of rates and differences."""
    caption, rates = _caption(run), run.kept("sim2sim", "rates")
    yield ReportFigure(
        sim2sim_figure(rates),
        "return_rate",
        title="Sim-to-sim transfer",
        caption=f"{caption} Whiskers: 95 % intervals over trainings and shots. "
        "Dots, if there are several policies: policies that differ only in the seed.",
    )
    yield ReportTable(
        rates[COLUMNS],
        "return_rate",
        title="Sim-to-sim: returns, hits and forecast errors",
        caption=f"{caption} Rates over all shots; ci: 95 % interval of the return rate "
        "over trainings and shots; std: over policies that differ only in the "
        "seed; forecast_error_m: mean distance between forecast and true position at the "
        "middle horizon, over all control steps before the ball is out of play.",
    )
    yield ReportTable(
        run.kept("sim2sim", "differences"),
        "difference",
        title="Sim-to-sim: gain of the ground truth's predictions",
        caption="Return rate with the ground truth's predictions minus that with the imperfect "
        "simulator's, paired by shot, with 95 % intervals over trainings and "
        "shots. gained, lost: shots returned more often with the one, or with the other.",
    )


def _caption(run: StageRun) -> str:
    settings = run.params.sim2sim
    protocols = "; ".join(f"{name}: {PROTOCOLS[name]}" for name in settings.protocols)
    return (
        "Policies trained in an imperfect simulator play the same "
        f"{settings.episodes} test shots, which the simulator {settings.ground_truth} flies to the "
        "robot and back. The predictor is either that ground truth or the policy's own imperfect "
        f"simulator. {protocols}."
    )


def sim2sim_figure(rates: pd.DataFrame) -> Figure:
    """Draw return rates: a panel per protocol, two bars per simulator and horizons.

    Args:
        rates: one row per protocol, simulator, horizons_ms and predictor (``GROUND_TRUTH`` or
            ``IMPERFECT``), with return_rate, ci_low and ci_high as shares, numbers of balls and of
            trainings, and per_seed, the list of the single policies' return rates.
    """
    protocols = list(rates["protocol"].unique())
    simulators = list(rates["simulator"].unique())
    blocks = {  # of bars: where the simulators stand with each triple of horizons
        str(horizons): block * (len(simulators) + GAP) + np.arange(len(simulators))
        for block, horizons in enumerate(rates["horizons_ms"].unique())
    }
    figure = Figure(figsize=(FIGURE_WIDTH, 1.0 + 2.5 * len(protocols)))
    grid = figure.subplots(len(protocols), 1, squeeze=False, sharex=True, sharey=True)[:, 0]
    for axes, protocol in zip(grid, protocols, strict=True):
        for predictor, (_, colour, side) in PREDICTORS.items():
            rows = rates[(rates["protocol"] == protocol) & (rates["predictor"] == predictor)]
            pairs = zip(rows["horizons_ms"], rows["simulator"], strict=True)
            across = [blocks[block][simulators.index(name)] + side * BAR for block, name in pairs]
            _draw_bars(axes, rows, across, colour)
        axes.set(ylabel="return rate (%)", ylim=(0, 109), yticks=range(0, 101, 25))
        axes.grid(visible=False, axis="x")
        axes.set_title(PROTOCOLS[protocol])
    names = [simulator_label(name) for name in simulators] * len(blocks)
    grid[-1].set_xticks(np.concatenate(list(blocks.values())), names)
    below = grid[-1].secondary_xaxis(-0.13)
    middles = [float(np.mean(block)) for block in blocks.values()]
    below.set_xticks(middles, [f"horizons {ahead(horizons)}" for horizons in blocks])
    below.tick_params(length=0)
    below.spines["bottom"].set_visible(False)
    _add_legend(figure, rates)
    return figure


def _draw_bars(axes: Axes, rows: pd.DataFrame, across: list[float], colour: str) -> None:
    height, ends = percent(rows, "ci_low")
    whiskers = {"ecolor": INK, "elinewidth": 1.0, "capsize": 2.5}
    axes.bar(across, height, BAR, yerr=ends, color=colour, error_kw=whiskers)
    tops = 100 * rows["ci_high"]
    for place, top, rate, policies in zip(across, tops, height, rows["per_seed"], strict=True):
        text = f"{rate:.0f}"
        axes.annotate(text, (place, top), (0, 3), textcoords="offset points", ha="center")
        if len(policies) > 1:
            axes.plot([place - BAR / 4] * len(policies), 100 * np.array(policies), **DOTS)


def _add_legend(figure: Figure, rates: pd.DataFrame) -> None:
    handles: list[Artist] = [
        Patch(color=colour, label=f"predictions by {label}")
        for label, colour, _ in PREDICTORS.values()
    ]
    label = f"95 % interval, {sample(rates)}"
    handles.append(Line2D([], [], color=INK, ls="", marker="|", ms=9, mew=1.0, label=label))
    if rates["per_seed"].map(len).max() > 1:
        handles.append(Line2D([], [], **DOTS, label="single policy"))
    figure.legend(handles=handles, loc="outside upper left", ncols=2)
