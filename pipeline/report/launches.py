"""Distributions of launches: strokes of simulated players and measured ones."""

from collections.abc import Iterator
from typing import Any

import numpy as np
import pandas as pd
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from scipy.stats import ks_2samp

from rallygap.pipeline.sources.launches import MEASURED, QUANTITIES
from rallygap.pipeline.web.figure_style import FIGURE_WIDTH, INK, MUTED

QUANTILES = {"5%": 0.05, "25%": 0.25, "50%": 0.5, "75%": 0.75, "95%": 0.95}
# The measured strokes are those of amateurs and club players.
COMPARED = "amateur and club"

PANELS = {"rallies and cannon": ("rally", "cannon"), "serves": ("serve",)}
PANEL_HEIGHT = 1.45  # inch
CUT_TAILS = 0.002  # of a panel's launches on each side, for a readable scale
LINES: dict[str, dict[str, Any]] = {
    "cannon": {"color": MUTED, "ls": ":"},
    "amateur": {"color": "#0f7fc4"},
    "club": {"color": "#009988"},
    "semi_pro": {"color": "#b85fa0"},
    "pro": {"color": "#d55e00"},
    MEASURED: {"color": INK, "lw": 2.6},
}


def launch_distributions(launches: pd.DataFrame) -> pd.DataFrame:
    """Return quantiles of every quantity, and how far each group is from the measured launches.

    Args:
        launches: of all groups, in the columns of ``simulated_launches``.

    Returns:
        One row a stroke, quantity and group; the distance is the largest between the distribution
        functions, after Kolmogorov, where launches of the same stroke were measured.
    """
    columns = ["stroke", "quantity", "group", "launches", *QUANTILES, "distance to measured"]
    return pd.DataFrame(list(_distributions(launches)), columns=columns)


def launches_figure(launches: pd.DataFrame) -> Figure:
    """Draw the distribution function of every quantity, one line a group.

    Args:
        launches: of all groups, in the columns of ``simulated_launches``; at least one.
    """
    panels = {
        title: launches[launches["stroke"].isin(strokes)] for title, strokes in PANELS.items()
    }
    panels = {title: drawn for title, drawn in panels.items() if len(drawn)}
    figure = Figure(figsize=(FIGURE_WIDTH, 0.5 + PANEL_HEIGHT * len(QUANTITIES)))
    grid = figure.subplots(len(QUANTITIES), len(panels), squeeze=False, sharey=True)
    for column, (title, drawn) in zip(grid.T, panels.items(), strict=True):
        column[0].set_title(title)
        for axes, (quantity, unit) in zip(column, QUANTITIES.items(), strict=True):
            _draw_distributions(axes, drawn, quantity)
            axes.set_xlabel(f"{quantity} ({unit})")
    figure.supylabel("share of launches below", fontsize="medium")
    lines = {line.get_label(): line for axes in grid[0] for line in axes.lines}
    figure.legend(handles=list(lines.values()), loc="outside upper center", ncols=len(lines))
    return figure


def _distributions(launches: pd.DataFrame) -> Iterator[tuple[Any, ...]]:
    amateurs = launches[launches["group"].isin(["amateur", "club"])].assign(group=COMPARED)
    for stroke, of_stroke in pd.concat([launches, amateurs]).groupby("stroke"):
        groups = dict(list(of_stroke.groupby("group", sort=False)))
        for quantity, unit in QUANTITIES.items():
            for name, group in groups.items():
                values = group[quantity]
                distance = np.nan
                if MEASURED in groups and name != MEASURED:
                    distance = _distance(values, groups[MEASURED][quantity])
                quantiles = values.quantile(list(QUANTILES.values()))
                yield stroke, f"{quantity} ({unit})", name, len(values), *quantiles, distance


def _distance(one: pd.Series, other: pd.Series) -> float:
    """Return the largest distance between two distribution functions."""
    return float(ks_2samp(one, other, method="asymp").statistic)


def _draw_distributions(axes: Axes, launches: pd.DataFrame, quantity: str) -> None:
    for group, line in LINES.items():
        values = launches[quantity][launches["group"] == group]
        if len(values):
            axes.ecdf(values, label=group.replace("_", "-"), **{"lw": 1.5, **line})
    low, high = launches[quantity].quantile([CUT_TAILS, 1 - CUT_TAILS])
    if low < high:
        axes.set_xlim(low, high)
