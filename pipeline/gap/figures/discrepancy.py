"""Figures of where a gap arises: the trajectory discrepancy by horizon, phase and covariate."""

from collections.abc import Sequence

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from rallygap.models.gap.location import Growth, Located
from rallygap.models.gap.types import PHASES, Phase
from rallygap.pipeline.gap.summary import SIGNIFICANT
from rallygap.pipeline.gap.wording import PLACES, p_text, percent
from rallygap.pipeline.web.figure_style import FIGURE_WIDTH, INK, MUTED
from rallygap.pipeline.web.report_items import ReportFigure

PHASE_COLOURS: dict[Phase, str] = {"flight": "#0f7fc4", "table": "#009988", "sensor": "#8a6fd1"}
DIRECTIONS = {"along": "#d55e00", "across": "#0f7fc4", "up": "#009988"}
MOST_AXES = 4
ROW_HEIGHT = 1.45  # inch
HEADROOM = 0.75  # inch, for titles and axis labels


def discrepancy_figure(located: Located) -> ReportFigure:
    """Draw the discrepancy over the horizon by phase, and its mean in three directions."""
    figure = Figure(figsize=(FIGURE_WIDTH, 3.4))
    left, right = figure.subplots(1, 2)
    times = np.concatenate([[0.0], 1000 * located.horizons])
    bands = [
        np.concatenate([[0.0], 1000 * located.discrepancy * located.shares[phase]])
        for phase in PHASES
    ]
    names = [f"{PLACES[phase]}, {percent(located.phase_shares[phase])}" for phase in PHASES]
    left.stackplot(times, bands, colors=PHASE_COLOURS.values(), labels=names, lw=0)
    left.plot(times, np.sum(bands, axis=0), color=INK, lw=1.2)
    left.set_ylabel("root mean square discrepancy (mm)")
    left.set_title("Size, by phase")
    _draw_means(right, located)
    right.set_ylabel("mean discrepancy (mm)")
    right.set_title("Mean of all shots, by direction")
    for axes in (left, right):
        axes.set_xlim(0, times[-1])
        axes.set_xlabel("prediction horizon (ms)")
    left.set_ylim(0, max(1.15 * float(np.sum(bands, axis=0).max()), 1.0))
    _legend_in_order(left)
    right.legend(loc="upper left", ncols=3, handlelength=1.2, columnspacing=1.2)
    return ReportFigure(
        figure,
        "discrepancy",
        title="Discrepancy between simulated and measured trajectories",
        caption="Simulated and measured trajectories have the same state at the twelfth sample; "
        "noise and bounce scatter are removed. Left: a band is the part that vanishes when the "
        "simulator's flight, table or measurement is replaced by the fitted one; the legend gives "
        "its share of the area. Right: mean along the horizontal direction of flight, across it "
        "(positive to the right) and up, with 95 % intervals.",
    )


def growth_figure(located: Located) -> ReportFigure:
    """Draw the discrepancy in three directions against the most informative covariates."""
    shown = located.growth[:MOST_AXES]
    figure = Figure(figsize=(FIGURE_WIDTH, HEADROOM + ROW_HEIGHT * len(DIRECTIONS)))
    grid = figure.subplots(len(DIRECTIONS), len(shown), squeeze=False, sharey=True, sharex="col")
    for column, growth in enumerate(shown):
        for row in range(len(DIRECTIONS)):
            _draw_growth(grid[row, column], growth, row)
        title = f"share {percent(growth.share)}, {p_text(growth.p_value)}"
        grid[0, column].set_title(title, loc="left", fontsize=8)
        _label_axis(grid[-1, column], growth)
    for row, direction in enumerate(DIRECTIONS):
        grid[row, 0].set_ylabel(f"{direction} (mm)")
    return ReportFigure(
        figure,
        "growth",
        title="Discrepancy against covariates",
        caption=f"Discrepancy {1000 * located.trend_horizon:.0f} ms ahead along the direction of "
        "flight, across it and up, estimated for each shot without assuming an effect: bin means "
        "with 95 % intervals, against the most informative covariates. Titles: share of the "
        "variance between shots that the covariate explains, and the p-value over all covariates "
        "(grey above 5 %). Correlated covariates, such as position and direction, explain the same "
        "variance.",
    )


def _draw_means(axes: Axes, located: Located) -> None:
    times = 1000 * located.horizons
    axes.axhline(0, color=INK, lw=1)
    for direction, (name, colour) in enumerate(DIRECTIONS.items()):
        mean, margin = 1000 * located.means[:, direction], 1000 * located.margins[:, direction]
        axes.fill_between(times, mean - margin, mean + margin, color=colour, alpha=0.2, lw=0)
        axes.plot(times, mean, color=colour, label=name)
    low, high = axes.get_ylim()
    axes.set_ylim(low, high + 0.15 * (high - low))


def _draw_growth(axes: Axes, growth: Growth, direction: int) -> None:
    significant = growth.p_value <= SIGNIFICANT
    colour = list(DIRECTIONS.values())[direction] if significant else MUTED
    places = _places(growth)
    axes.axhline(0, color=INK, lw=1)
    axes.errorbar(
        places,
        1000 * growth.means[:, direction],
        1000 * growth.margins[:, direction],
        fmt="o" if growth.kinds else "o-",
        color=colour,
        ms=4,
        lw=1.2,
        elinewidth=1.2,
    )
    axes.margins(x=0.25 if growth.kinds else 0.1)


def _label_axis(axes: Axes, growth: Growth) -> None:
    unit = f" ({growth.unit})" if growth.unit else ""
    axes.set_xlabel(f"{growth.covariate}{unit}")
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
