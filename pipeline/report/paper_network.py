"""Figure of the paper's network: its errors next to those of others, and its training."""

from collections.abc import Iterator

import pandas as pd
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.ticker import FixedLocator, NullLocator

from rallygap.pipeline.runtime.stage_run import StageRun
from rallygap.pipeline.web.figure_style import FIGURE_WIDTH, predictor_colour
from rallygap.pipeline.web.report_items import ReportFigure, ReportItem

LOSSES = (0.05, 0.1, 0.2, 0.5, 1, 2)
# Predictor to label and dashes.
LINES = {
    "physics_c_with_net": ("simulator C with a net", "-"),
    "paper_network": ("transformer of the paper's size", "--"),
    "transformer": ("transformer", "-"),
    "hybrid": ("hybrid", "-"),
    "oracle": ("oracle: the true physics", "-"),
}


def items(run: StageRun) -> Iterator[ReportItem]:
    """Yield errors and losses of the paper's network."""
    errors, curve = (run.published("paper_network", name) for name in ("errors", "training"))
    yield ReportFigure(
        paper_network_figure(errors, curve),
        "errors",
        title="The paper's network",
        caption="Left: mean position error on test recordings 100, 200 and 300 ms ahead. Right: "
        "losses of the paper's network over the epochs.",
    )


def paper_network_figure(errors: pd.DataFrame, curve: pd.DataFrame) -> Figure:
    """Draw mean position errors over the horizon, and losses over the epochs.

    Args:
        errors: of ``ForecastErrors.over_horizon``, perhaps at some horizons only.
        curve: ``epoch``, ``training`` and ``validation`` loss of the paper's network.
    """
    figure = Figure(figsize=(FIGURE_WIDTH, 3.4))
    left, right = figure.subplots(1, 2)
    _draw_errors(left, errors.query("quantity == 'position' and bounce == 'all'"))
    colour = predictor_colour("transformer")
    for name, dashes in (("training", ":"), ("validation", "--")):
        right.plot(curve["epoch"], curve[name], dashes, color=colour, label=name)
    right.set_yscale("log")
    right.yaxis.set_major_locator(FixedLocator(LOSSES))
    right.yaxis.set_major_formatter("{x:g}")
    right.yaxis.set_minor_locator(NullLocator())
    right.set_title("training of the paper's size")
    right.set_xlabel("epoch")
    right.set_ylabel("mean squared error, normalised")
    right.legend()
    return figure


def _draw_errors(axes: Axes, errors: pd.DataFrame) -> None:
    for predictor, (label, dashes) in LINES.items():
        line = errors.query("predictor == @predictor").sort_values("horizon_ms")
        colour = predictor_colour("transformer" if predictor == "paper_network" else predictor)
        horizons = line["horizon_ms"]
        axes.fill_between(horizons, line["ci_low"], line["ci_high"], color=colour, alpha=0.15, lw=0)
        axes.plot(horizons, line["mean"], dashes, color=colour, label=label)
    axes.set_ylim(bottom=0)
    axes.set_title("mean error on test recordings")
    axes.set_xlabel("forecast horizon (ms)")
    axes.set_ylabel("position error (mm)")
    axes.legend(fontsize=8)
