"""Figure of return rates before and after retraining."""

import pandas as pd
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from rallygap.pipeline.io.figure_style import FIGURE_WIDTH, INK, MUTED, predictor_colour
from rallygap.pipeline.io.labels import predictor_label
from rallygap.pipeline.transfer.figures.sample import sample

ROW = 0.3  # inch per bar
HEADROOM = 1.0  # inch, for the title and the axis


def retraining_figure(table: pd.DataFrame) -> Figure:
    """Draw return rates by policy and predictor: a column per set, a row per triple of horizons.

    Args:
        table: one row per ``set``, ``horizons_ms``, ``policy`` and ``predictor``, with ``balls``,
            ``trainings``, ``return_rate``, ``return_rate_low`` and ``return_rate_high``.
    """
    sets, horizons = list(table["set"].unique()), list(table["horizons_ms"].unique())
    bars = len(table[["policy", "predictor"]].drop_duplicates())
    height = len(horizons) * (HEADROOM + ROW * bars)
    figure = Figure(figsize=(FIGURE_WIDTH, height))
    grid = figure.subplots(len(horizons), len(sets), sharex=True, squeeze=False)
    for axes_row, label in zip(grid, horizons, strict=True):
        for axes, name in zip(axes_row, sets, strict=True):
            rows = table[(table["set"] == name) & (table["horizons_ms"] == label)]
            _draw_panel(axes, rows)
            axes.set_title(f"{name}, horizons {label.replace('-', '–')} ms, {sample(rows)}")
    for axes in grid[-1]:
        axes.set_xlabel("return rate (%)")
    return figure


def _draw_panel(axes: Axes, rows: pd.DataFrame) -> None:
    rate = 100 * rows["return_rate"]
    ends = [rate - 100 * rows["return_rate_low"], 100 * rows["return_rate_high"] - rate]
    pairs = rows[["policy", "predictor"]].to_numpy(dtype=str)
    names = [f"{policy} policy, {predictor_label(str(predictor))}" for policy, predictor in pairs]
    colours = [_colour(str(predictor)) for _, predictor in pairs]
    whiskers = {"ecolor": INK, "elinewidth": 0.9, "capsize": 2}
    axes.barh(range(len(rows)), rate, 0.7, color=colours, xerr=ends, error_kw=whiskers)
    axes.set_yticks(range(len(rows)), names)
    axes.set(xlim=(0, 100), ylim=(len(rows) - 0.5, -0.5))
    axes.grid(visible=False, axis="y")
    axes.axvline(rate.iloc[0], color=MUTED, lw=0.9, ls="--")


def _colour(predictor: str) -> str:
    return predictor_colour("physics_c" if predictor == "physics" else predictor)
