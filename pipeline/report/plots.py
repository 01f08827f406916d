"""What figures of several reports share: intervals of rates, names of rows, legends, words."""

from collections.abc import Sequence
from textwrap import fill
from typing import Any

import pandas as pd
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from rallygap.pipeline.web.figure_style import INK, predictor_colour

BARS = 0.84  # width of all bars of a set; sets are 1 apart
Ends = list[pd.Series]  # how far an interval reaches below and above each value
WHISKERS: dict[str, Any] = {"ecolor": INK, "elinewidth": 0.9, "capsize": 2}


def percent(rows: pd.DataFrame, low: str = "return_rate_low") -> tuple[pd.Series, Ends]:
    """Return the column ``return_rate`` in percent with its intervals.

    Args:
        rows: shares.
        low: column with the lower ends; that of the upper ends has ``high`` in its place.
    """
    rate = 100 * rows["return_rate"]
    return rate, [rate - 100 * rows[low], 100 * rows[low.replace("low", "high")] - rate]


def draw_band(axes: Axes, across: pd.Series, rows: pd.DataFrame, colour: str, alpha: float) -> None:
    """Shade between the columns ``ci_low`` and ``ci_high``."""
    axes.fill_between(across, rows["ci_low"], rows["ci_high"], color=colour, alpha=alpha, lw=0)


def label_rows(axes: Axes, names: Sequence[str]) -> None:
    """Name the rows of a panel, the first on top."""
    axes.set_yticks(range(len(names)), names)
    axes.set_ylim(len(names) - 0.5, -0.5)


def add_legend(figure: Figure, axes: Axes, **style: Any) -> None:
    """Add the legend of one panel outside all of them, below where ``loc`` does not say else."""
    handles, labels = axes.get_legend_handles_labels()
    figure.legend(handles, labels, **{"loc": "outside lower center", **style})


def physics_colour(predictor: str) -> str:
    """Return the colour of a predictor of policies, whose own simulator is called physics."""
    return predictor_colour("physics_c" if predictor == "physics" else predictor)


def ahead(horizons: str) -> str:
    """Return such as ``115–125 ms``."""
    return f"{horizons.replace('-', '–')} ms"


def set_label(name: object) -> str:
    """Return the name of a set in lines of at most 12 letters."""
    return fill(str(name).replace("_", " "), 12)


def sample(rates: pd.DataFrame) -> str:
    """Return such as ``300 shots, 2 trainings``.

    Args:
        rates: with columns ``balls`` and ``trainings``, each the same in all rows.
    """
    return f"{rates['balls'].iloc[0]:,} shots, {trainings(rates)}"


def trainings(rates: pd.DataFrame) -> str:
    """Return such as ``2 trainings``, of the column ``trainings``."""
    count = rates["trainings"].iloc[0]
    return f"{count} training{'s' if count > 1 else ''}"
