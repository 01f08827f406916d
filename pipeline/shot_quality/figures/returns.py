"""Figures of shot quality: medians of the returns, and calibration."""

from textwrap import fill

import pandas as pd
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.patches import Patch

from rallygap.pipeline.io.figure_style import (
    FIGURE_WIDTH,
    INK,
    MUTED,
    predictor_colour,
    predictor_order,
)
from rallygap.pipeline.io.labels import predictor_label

BARS = 0.84  # width of all bars of a set; sets are 1 apart
LABEL = 12  # letters of a set's name in a line
HATCH = "////"  # the shorter horizons, as in the paper
METHOD_COLOURS = {"logistic": "#d55e00", "forest": "#0f7fc4"}


def medians_figure(table: pd.DataFrame, metrics: dict[str, str]) -> Figure:
    """Draw a panel a metric: its medians for every set, predictor and horizons, with intervals.

    Args:
        table: one row a ``set``, ``horizons_ms`` and ``predictor``, with the metrics' columns and
            the ends of their intervals, ``..._low`` and ``..._high``.
        metrics: column to title.
    """
    sets, horizons = list(table["set"].unique()), list(table["horizons_ms"].unique())
    predictors = sorted(table["predictor"].unique(), key=_order)
    figure = Figure(figsize=(FIGURE_WIDTH, 1.0 + 1.75 * len(metrics)))
    grid = figure.subplots(len(metrics), 1, sharex=True, squeeze=False)[:, 0]
    for axes, (column, title) in zip(grid, metrics.items(), strict=True):
        _draw_panel(axes, table, column, predictors)
        axes.set_title(title)
    grid[-1].set_xticks(range(len(sets)), [fill(one.replace("_", " "), LABEL) for one in sets])
    handles = [Patch(color=_colour(one), label=predictor_label(one)) for one in predictors]
    handles += [
        Patch(facecolor="none", edgecolor=MUTED, hatch=_hatch(one, horizons), label=f"{one} ms")
        for one in horizons
    ]
    figure.legend(handles=handles, loc="outside upper left", ncols=4)
    return figure


def calibration_figure(table: pd.DataFrame, share: float) -> Figure:
    """Draw the share of the shots that won over their estimated probability.

    Args:
        table: one row a ``method`` and bin, with ``probability`` and ``share``.
        share: of all shots that won.
    """
    figure = Figure(figsize=(FIGURE_WIDTH / 2, 3.4))
    axes = figure.subplots()
    end = 1.05 * table[["probability", "share"]].to_numpy().max()
    axes.plot([0, end], [0, end], color=MUTED, lw=0.9, label="perfect calibration")
    axes.axhline(share, color=MUTED, lw=0.9, ls=":", label="base rate")
    for method, colour in METHOD_COLOURS.items():
        rows = table[table["method"] == method]
        axes.plot(rows["probability"], rows["share"], ".-", color=colour, label=method)
    axes.set(xlabel="estimated winning probability", ylabel="share of shots that won")
    axes.set(xlim=(0, end), ylim=(0, end))
    axes.legend()
    return figure


def _draw_panel(axes: Axes, table: pd.DataFrame, column: str, predictors: list[str]) -> None:
    sets, horizons = list(table["set"].unique()), list(table["horizons_ms"].unique())
    width = BARS / (len(predictors) * len(horizons))
    whiskers = {"ecolor": INK, "elinewidth": 0.9, "capsize": 1.5}
    known = table[table[column].notna()]
    for row in known.to_dict("records"):
        place = predictors.index(row["predictor"]) * len(horizons)
        place += horizons.index(row["horizons_ms"])
        across = sets.index(row["set"]) - BARS / 2 + (place + 0.5) * width
        height = row[column]
        ends = [[max(height - row[f"{column}_low"], 0)], [max(row[f"{column}_high"] - height, 0)]]
        axes.bar(
            across,
            height,
            0.9 * width,
            color=_colour(row["predictor"]),
            edgecolor="white",
            linewidth=0.0,
            hatch=_hatch(row["horizons_ms"], horizons),
            yerr=ends,
            error_kw=whiskers,
        )
    axes.grid(visible=False, axis="x")


def _hatch(ahead: str, horizons: list[str]) -> str:
    return HATCH if ahead == horizons[0] else ""


def _order(predictor: str) -> tuple[bool, tuple[int, str]]:
    return predictor != "physics", predictor_order(predictor)


def _colour(predictor: str) -> str:
    return predictor_colour("physics_c" if predictor == "physics" else predictor)
