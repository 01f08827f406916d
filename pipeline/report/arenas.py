"""Figure of the arenas: errors next to the oracle's, and causes found by their size."""

from collections.abc import Iterator

import numpy as np
import pandas as pd
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.ticker import MaxNLocator

from rallygap.pipeline.experiments.arena_scores import PREDICTORS, found_by_size, ratios
from rallygap.pipeline.paper.assessments import rate
from rallygap.pipeline.runtime.stage_run import StageRun
from rallygap.pipeline.web.figure_style import FIGURE_WIDTH, INK, predictor_colour
from rallygap.pipeline.web.report_items import ReportFigure, ReportItem

HORIZON_MS = 300
MARKED = "#0f7fc4"
FORECAST_BY = {"imperfect_c": "physics_c", "imperfect_c_with_net": "physics_c_with_net"}


def items(run: StageRun) -> Iterator[ReportItem]:
    """Yield the figure of all arenas."""
    yield ReportFigure(
        arenas_figure(run.published("arenas", "causes"), run.published("arenas", "errors")),
        "arenas",
        title="Twenty fresh arenas",
        caption="Left: position errors on test recordings of each arena over those of its own "
        "physics. Right: share of the hidden differences that are named, by their size.",
    )


def arenas_figure(causes: pd.DataFrame, errors: pd.DataFrame) -> Figure:
    """Draw each arena's errors over the oracle's, and the share of causes found by size.

    Args:
        causes: of all arenas.
        errors: of all arenas.
    """
    figure = Figure(figsize=(FIGURE_WIDTH, 3.4))
    left, right = figure.subplots(1, 2, width_ratios=(3, 2))
    _draw_ratios(left, errors)
    _draw_found(right, causes)
    return figure


def _draw_ratios(axes: Axes, errors: pd.DataFrame) -> None:
    """Draw the arenas in the order of their ratios, a line a predictor."""
    for name, label in PREDICTORS.items():
        ordered = np.sort(ratios(errors, name, HORIZON_MS).to_numpy())
        ranks = np.arange(1, len(ordered) + 1)
        colour = predictor_colour(FORECAST_BY.get(name, name))
        axes.plot(ranks, ordered, color=colour, marker="o", markersize=3, label=label)
    axes.axhline(1.0, color=INK, linewidth=0.8)
    axes.set_yscale("log")
    axes.yaxis.set_major_formatter("{x:g}")
    axes.yaxis.set_minor_formatter("{x:g}")
    axes.xaxis.set_major_locator(MaxNLocator(integer=True))
    axes.set_xlabel("arena, in the order of each line")
    axes.set_ylabel(f"error {HORIZON_MS} ms ahead / oracle's")
    axes.legend(loc="best")


def _draw_found(axes: Axes, causes: pd.DataFrame) -> None:
    names = []
    for place, (name, named, hidden) in enumerate(found_by_size(causes)):
        names.append(f"{name}\nn = {hidden}")
        if not hidden:
            continue
        found = rate(named, hidden).times(100)
        axes.plot([place, place], [found.low, found.high], color=MARKED)
        axes.plot(place, found.value, color=MARKED, marker="o", markersize=5)
    axes.set_xticks(range(len(names)), names)
    axes.set_ylim(-3, 103)
    axes.set_xlabel("size (minimum detectable effects)")
    axes.set_ylabel("hidden differences named (%)")
    axes.grid(visible=False, axis="x")
