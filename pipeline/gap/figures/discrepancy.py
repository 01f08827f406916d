"""Where a gap arises, in pictures: the parting over the horizon, and against what it grows."""

from collections.abc import Sequence

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from models.gap.location import Growth, Located
from models.gap.types import PHASES
from pipeline.gap.summary import TELLING
from pipeline.gap.wording import PLACES, chance, percent
from pipeline.io.figure_style import FIGURE_WIDTH, INK, MUTED

PHASE_COLOURS = {"flight": "#0f7fc4", "table": "#009988", "sensor": "#8a6fd1"}
WAYS = {"along": "#d55e00", "across": "#0f7fc4", "up": "#009988"}
MOST_AXES = 4
ROW_HEIGHT = 1.45  # inch
HEADROOM = 0.75  # inch, for titles and the axis' names


def parting_figure(located: Located) -> Figure:
    """Draw how far balls part over the horizon, by phases, and which way they go."""
    figure = Figure(figsize=(FIGURE_WIDTH, 3.4))
    left, right = figure.subplots(1, 2)
    times = np.concatenate([[0.0], 1000 * located.horizons])
    bands = [
        np.concatenate([[0.0], 1000 * located.discrepancy * located.shares[one]]) for one in PHASES
    ]
    names = [f"{PLACES[one]}, {percent(located.where[one])}" for one in PHASES]
    left.stackplot(times, bands, colors=PHASE_COLOURS.values(), labels=names, lw=0)
    left.plot(times, np.sum(bands, axis=0), color=INK, lw=1.2)
    left.set_ylabel("root mean square parting (mm)")
    left.set_title("How far, and where it arises")
    _draw_time(right, located.time)
    right.set_ylabel("mean parting (mm)")
    right.set_title("Which way, on the mean of all shots")
    for axes in (left, right):
        axes.set_xlim(0, times[-1])
        axes.set_xlabel("time after the twelfth sample (ms)")
    left.set_ylim(0, max(1.15 * float(np.sum(bands, axis=0).max()), 1.0))
    _legend_in_order(left)
    right.legend(loc="upper left", ncols=3, handlelength=1.2, columnspacing=1.2)
    return figure


def growth_figure(located: Located) -> Figure:
    """Draw the parting along, across and up against the most telling axes, as small multiples."""
    shown = located.growth[:MOST_AXES]
    figure = Figure(figsize=(FIGURE_WIDTH, HEADROOM + ROW_HEIGHT * len(WAYS)))
    grid = figure.subplots(len(WAYS), len(shown), squeeze=False, sharey=True, sharex="col")
    for column, growth in enumerate(shown):
        for row in range(len(WAYS)):
            _draw_growth(grid[row, column], growth, row)
        title = f"share {percent(growth.share)}, {chance(growth.p_value)}"
        grid[0, column].set_title(title, loc="left", fontsize=8)
        _label_axis(grid[-1, column], growth)
    for row, way in enumerate(WAYS):
        grid[row, 0].set_ylabel(f"{way} (mm)")
    return figure


def _draw_time(axes: Axes, growth: Growth) -> None:
    axes.axhline(0, color=INK, lw=1)
    for way, (name, colour) in enumerate(WAYS.items()):
        mean, error = 1000 * growth.means[:, way], 1000 * growth.errors[:, way]
        axes.fill_between(growth.centres, mean - error, mean + error, color=colour, alpha=0.2, lw=0)
        axes.plot(growth.centres, mean, color=colour, label=name)
    low, high = axes.get_ylim()
    axes.set_ylim(low, high + 0.15 * (high - low))


def _draw_growth(axes: Axes, growth: Growth, way: int) -> None:
    telling = growth.p_value <= TELLING
    colour = list(WAYS.values())[way] if telling else MUTED
    places = _places(growth)
    axes.axhline(0, color=INK, lw=1)
    axes.errorbar(
        places,
        1000 * growth.means[:, way],
        1000 * growth.errors[:, way],
        fmt="o" if growth.kinds else "o-",
        color=colour,
        ms=4,
        lw=1.2,
        elinewidth=1.2,
    )
    axes.margins(x=0.25 if growth.kinds else 0.1)


def _label_axis(axes: Axes, growth: Growth) -> None:
    unit = f" ({growth.unit})" if growth.unit else ""
    axes.set_xlabel(f"{growth.axis}{unit}")
    if growth.kinds:
        names = [name.replace(" ", "\n") for name in growth.kinds]
        axes.set_xticks(_places(growth), names, fontsize=7)
    else:
        axes.locator_params(axis="x", nbins=4)


def _places(growth: Growth) -> Sequence[float] | np.ndarray:
    return range(len(growth.kinds)) if growth.kinds else growth.centres


def _legend_in_order(axes: Axes) -> None:
    """Add the legend in the order in which bands lie above one another."""
    handles, names = axes.get_legend_handles_labels()
    axes.legend(handles[::-1], names[::-1], loc="upper left")
