"""Figures of the experiments on forecasts: arenas, recordings, measured sets, a larger network."""

from collections.abc import Iterator

import numpy as np
import pandas as pd
from matplotlib.axes import Axes
from matplotlib.axis import Axis
from matplotlib.figure import Figure
from matplotlib.ticker import FixedLocator, MaxNLocator, NullLocator

from experiments.arena_scores import PREDICTORS, found_by_size, ratios
from rallygap.pipeline.paper.assessments import rate
from rallygap.pipeline.report.plots import add_legend, draw_band, label_rows
from rallygap.pipeline.runtime.stage_run import StageRun
from rallygap.pipeline.web.figure_style import FIGURE_WIDTH, INK, predictor_colour
from rallygap.pipeline.web.report_items import ReportFigure

FARTHEST_MS = 300
MARKED = "#0f7fc4"
# What has the colour of another predictor.
COLOURED_AS = {
    "imperfect_c": "physics_c",
    "imperfect_c_with_net": "physics_c_with_net",
    "paper_network": "transformer",
}
ERRORS_MM = (10, 20, 30, 50, 100, 200)
LOSSES = (0.05, 0.1, 0.2, 0.5, 1, 2)
# Predictors of the learning curves.
LEARNERS = {
    "oracle": "oracle: the true physics",
    "amended_imperfect_c": "simulator C, amended",
    "hybrid": "hybrid: network on simulator C with a net",
    "transformer": "transformer",
}
# Predictors that recordings of a measured set have amended or fine-tuned.
ADAPTED = {
    "physics_literature": "literature",
    "amended": "literature amended",
    "hybrid": "hybrid on the amended simulator",
    "transformer": "transformer",
    "transformer_ensemble": "ensemble of two transformers",
    "hybrid_ensemble": "ensemble of hybrid and transformer",
}
HORIZONS = {100: ("o", "#8fc4e8"), 200: ("s", "#0f7fc4"), 300: ("D", "#0a3f66")}
# What the paper's network is compared with: label and dashes.
NETWORKS = {
    "physics_c_with_net": ("simulator C with a net", "-"),
    "paper_network": ("transformer of the paper's size", "--"),
    "transformer": ("transformer", "-"),
    "hybrid": ("hybrid", "-"),
    "oracle": ("oracle: the true physics", "-"),
}


def arenas(run: StageRun) -> Iterator[ReportFigure]:
    """Yield the figure of all arenas."""
    yield ReportFigure(
        arenas_figure(run.published("arenas", "causes"), run.published("arenas", "errors")),
        "arenas",
        title="Twenty fresh arenas",
        caption="Left: position errors on test recordings of each arena over those of its own "
        "physics. Right: share of the hidden differences that are named, by their size.",
    )


def learning_curves(run: StageRun) -> Iterator[ReportFigure]:
    """Yield position errors over the number of recordings."""
    yield ReportFigure(
        learning_curves_figure(run.published("learning_curves", "errors")),
        "errors",
        title="Errors by the number of training recordings",
        caption="Mean position error on the arena's test windows, with 95 % intervals over draws "
        "and test recordings.",
    )


def real_forecasts(run: StageRun) -> Iterator[ReportFigure]:
    """Yield position errors on measured sets."""
    yield ReportFigure(
        real_forecasts_figure(run.published("real_forecasts", "errors")),
        "errors",
        title="Forecast errors on measured sets",
        caption="Mean position error by cross-validation over recordings, with 95 % intervals "
        "bootstrapped over recordings.",
    )


def paper_network(run: StageRun) -> Iterator[ReportFigure]:
    """Yield errors and losses of the paper's network."""
    errors, curve = (run.published("paper_network", name) for name in ("errors", "training"))
    yield ReportFigure(
        paper_network_figure(errors, curve),
        "errors",
        title="The paper's network",
        caption="Left: mean position error on test recordings 100, 200 and 300 ms ahead. Right: "
        "losses of the paper's network over the epochs.",
    )


def arenas_figure(causes: pd.DataFrame, errors: pd.DataFrame) -> Figure:
    """Draw each arena's errors over the oracle's, and the share of causes found by size.

    Args:
        causes: of all arenas.
        errors: of all arenas; a line has them in the order of their ratios.
    """
    figure = Figure(figsize=(FIGURE_WIDTH, 3.4))
    left, right = figure.subplots(1, 2, width_ratios=(3, 2))
    for name, label in PREDICTORS.items():
        ordered = np.sort(ratios(errors, name, FARTHEST_MS).to_numpy())
        ranks = np.arange(1, len(ordered) + 1)
        left.plot(ranks, ordered, color=_colour(name), marker="o", markersize=3, label=label)
    left.axhline(1.0, color=INK, linewidth=0.8)
    left.set_yscale("log")
    left.yaxis.set_major_formatter("{x:g}")
    left.yaxis.set_minor_formatter("{x:g}")
    left.xaxis.set_major_locator(MaxNLocator(integer=True))
    left.set_xlabel("arena, in the order of each line")
    left.set_ylabel(f"error {FARTHEST_MS} ms ahead / oracle's")
    left.legend(loc="best")
    _draw_found(right, causes)
    return figure


def _draw_found(axes: Axes, causes: pd.DataFrame) -> None:
    names = []
    for place, (name, named, hidden) in enumerate(found_by_size(causes)):
        names.append(f"{name}\nn = {hidden}")
        if hidden:
            share = rate(named, hidden).times(100)
            axes.plot([place, place], [share.low, share.high], color=MARKED)
            axes.plot(place, share.value, color=MARKED, marker="o", markersize=5)
    axes.set_xticks(range(len(names)), names)
    axes.set_ylim(-3, 103)
    axes.set_xlabel("size (minimum detectable effects)")
    axes.set_ylabel("hidden differences named (%)")
    axes.grid(visible=False, axis="x")


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
        for predictor, label in LEARNERS.items():
            line = rows.query("predictor == @predictor and horizon_ms == @horizon")
            recordings, colour = line["recordings"], _colour(predictor)
            draw_band(axes, recordings, line, colour, alpha=0.2)
            axes.plot(recordings, line["mean"], color=colour, marker="o", markersize=3, label=label)
        axes.set_xscale("log")
        axes.set_yscale("log")
        _tick_only(axes.xaxis, sizes)
        axes.set_xticks(sizes, [f"{size:,}" for size in sizes])
        _tick_only(axes.yaxis, ERRORS_MM)
        axes.set_title(f"{horizon} ms ahead")
        axes.set_xlabel("training recordings")
    grid[0].set_ylabel("position error (mm)")
    add_legend(figure, grid[0], ncols=2)
    return figure


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
        for horizon, (marker, colour) in HORIZONS.items():
            members = shown[(shown["set"] == name) & (shown["horizon_ms"] == horizon)]
            errors = members.set_index("predictor").loc[names]
            mean = errors["mean"]
            axes.errorbar(
                mean, range(len(names)), xerr=[mean - errors["ci_low"], errors["ci_high"] - mean],
                fmt=marker, color=colour, markersize=4, capsize=2, label=f"{horizon} ms ahead",
            )  # fmt: skip
        axes.set_title(name)
        axes.set_xlim(left=0)
        axes.set_xlabel("position error (mm)")
        axes.grid(visible=False, axis="y")
    label_rows(grid[0], list(ADAPTED.values()))
    add_legend(figure, grid[0], ncols=3)
    return figure


def paper_network_figure(errors: pd.DataFrame, curve: pd.DataFrame) -> Figure:
    """Draw mean position errors over the horizon, and losses over the epochs.

    Args:
        errors: of ``ForecastErrors.over_horizon``, perhaps at some horizons only.
        curve: ``epoch``, ``training`` and ``validation`` loss of the paper's network.
    """
    figure = Figure(figsize=(FIGURE_WIDTH, 3.4))
    left, right = figure.subplots(1, 2)
    errors = errors.query("quantity == 'position' and bounce == 'all'")
    for predictor, (label, dashes) in NETWORKS.items():
        line = errors.query("predictor == @predictor").sort_values("horizon_ms")
        draw_band(left, line["horizon_ms"], line, _colour(predictor), alpha=0.15)
        left.plot(line["horizon_ms"], line["mean"], dashes, color=_colour(predictor), label=label)
    left.set_ylim(bottom=0)
    left.set(xlabel="forecast horizon (ms)", ylabel="position error (mm)")
    left.set_title("mean error on test recordings")
    left.legend(fontsize=8)
    for name, dashes in (("training", ":"), ("validation", "--")):
        right.plot(curve["epoch"], curve[name], dashes, color=_colour("transformer"), label=name)
    right.set_yscale("log")
    _tick_only(right.yaxis, LOSSES)
    right.set(xlabel="epoch", ylabel="mean squared error, normalised")
    right.set_title("training of the paper's size")
    right.legend()
    return figure


def _tick_only(axis: Axis, ticks: tuple[float, ...] | list[float]) -> None:
    axis.set_major_locator(FixedLocator(ticks))
    axis.set_major_formatter("{x:g}")
    axis.set_minor_locator(NullLocator())


def _colour(predictor: str) -> str:
    return predictor_colour(COLOURED_AS.get(predictor, predictor))
