"""Figures of one verdict: causes, cameras, where the gap arises, and errors before and after."""

from collections.abc import Sequence
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.cm import ScalarMappable
from matplotlib.colors import Normalize
from matplotlib.figure import Figure
from matplotlib.patches import Rectangle
from scipy.spatial import cKDTree

from rallygap.models.ball.sensor import measured_positions
from rallygap.models.ball.simulator import Simulator
from rallygap.models.ball.state import TABLE_HALF_LENGTH, TABLE_HALF_WIDTH
from rallygap.models.ball.types import Floats
from rallygap.models.gap.location import Growth, Located
from rallygap.models.gap.types import PHASES, Phase
from rallygap.models.gap.verdict import Cause, Gap, Verdict
from rallygap.pipeline.web.figure_style import FIGURE_WIDTH, INK, MUTED
from rallygap.pipeline.web.labels import KIND_NAMES, PLACES
from rallygap.pipeline.web.numbers import SIGNIFICANT, number, p_text, percent, with_unit
from rallygap.pipeline.web.report_items import ReportFigure

KIND_COLOURS = {"wrong_value": "#0f7fc4", "missing_effect": "#d55e00"}
LINES = {
    "before": ("#d55e00", "-", "o"),
    "after": ("#0f7fc4", "-", "s"),
    "floor": (MUTED, "--", ""),
}
LINE_NAMES = {
    "before": "nominal simulator",
    "after": "amended simulator",
    "floor": "prediction floor",
}
HIDDEN = "#e9edf0"  # departures below the minimum detectable effect
BELOW_MINIMUM = "below the minimum detectable effect"
BAND = 0.15  # opacity of intervals
ROW_HEIGHT = 0.55  # inch, of a cause
HEADROOM = 1.1  # inch, for the axis and the legend

CAMERA = "camera_distortion"
HEIGHTS = (0.1, 0.3, 0.6)  # m above the table
STEP = 0.1  # m, of the map; there is an arrow at every third place
ARROW_EVERY = 3
NEAR = 0.15  # m, from a measured ball: farther away nothing is known
OUTERMOST = 0.005  # share of the balls on each side that the map leaves out
ARROW = 0.25  # m on the map, of an error as large as the scale says
COLOURS = "RdBu_r"
NICE = np.array([0.5, 1.0, 2.0, 5.0, 10.0, 20.0, 50.0])  # mm

PHASE_COLOURS: dict[Phase, str] = {"flight": "#0f7fc4", "table": "#009988", "sensor": "#8a6fd1"}
DIRECTIONS = {"along": "#d55e00", "across": "#0f7fc4", "up": "#009988"}
MOST_COVARIATES = 4
GROWTH_HEIGHT = 5.1  # inch


def causes_figure(verdict: Verdict) -> ReportFigure:
    """Draw the departure of every main cause from the nominal simulator; there is at least one."""
    rows = len(verdict.main_causes)
    figure = Figure(figsize=(FIGURE_WIDTH, HEADROOM + ROW_HEIGHT * rows))
    axes = figure.subplots()
    shade_undetectable(axes)
    style: dict[str, Any] = {"textcoords": "offset points", "va": "center", "fontsize": 8}
    for row, cause in enumerate(verdict.main_causes):
        high = draw_departure(axes, row, cause, verdict, line=3, mark=7)
        text = f"{with_unit(cause.estimate, cause.unit)}, simulator {number(cause.nominal)}"
        if high is None:
            text, high = f"{text}; no minimum detectable effect", 0.0
        axes.annotate(text, (high, row), (8, 0), color=MUTED, **style)
    axes.set_yticks(range(rows), [cause.identity for cause in verdict.main_causes])
    axes.set_ylim(rows - 0.5, -0.5)
    axes.margins(x=0.3)
    axes.grid(axis="y", visible=False)
    axes.set_xlabel("estimate − simulator, in minimum detectable effects (5.8 σ)")
    add_legend(figure)
    return ReportFigure(
        figure,
        "causes",
        title="Estimated causes",
        caption="Estimate and 95 % interval of leading causes and sensor faults, less the "
        "simulator's value, in minimum detectable effects (5.8 standard errors with the "
        "simulator's own parameters free). Effects in the shaded band may not be detected.",
    )


def error_figure(gap: Gap) -> ReportFigure:
    """Draw the prediction error over the horizon: before, after and the floor."""
    figure = Figure(figsize=(FIGURE_WIDTH, 3.6))
    axes = figure.subplots()
    draw_errors(axes, gap)
    axes.set_ylim(bottom=0)
    axes.set_xlabel("prediction horizon (ms)")
    axes.set_ylabel("position error (mm)")
    figure.legend(loc="outside upper left", ncols=3)
    return ReportFigure(
        figure,
        "errors",
        title="Prediction error over the horizon",
        caption="Root mean square error on held-out shots, each predicted from its first twelve "
        "samples, with the nominal and the amended simulator. Bands: 95 %, bootstrap over shots. "
        "Prediction floor: error of a correct simulator with the same noise and bounce scatter.",
    )


def add_legend(figure: Figure) -> None:
    """Add the legend of all panels above them, each label once."""
    legends = [zip(*axes.get_legend_handles_labels(), strict=True) for axes in figure.axes]
    unique = {name: handle for legend in legends for handle, name in legend}
    figure.legend(unique.values(), unique.keys(), loc="outside upper left", ncols=3)


def draw_errors(axes: Axes, gap: Gap) -> None:
    """Draw errors over the horizon, with 95 % bands of the measured ones."""
    for name, (colour, line, marker) in LINES.items():
        values = getattr(gap, f"{name}_mm")
        axes.plot(
            gap.horizons_ms, values, line + marker, color=colour, label=LINE_NAMES[name], ms=4
        )
    for name in ("before", "after"):
        low, high = np.transpose(getattr(gap, f"{name}_interval_mm"))
        axes.fill_between(gap.horizons_ms, low, high, color=LINES[name][0], alpha=BAND, lw=0)


def shade_undetectable(axes: Axes) -> None:
    """Shade departures below the minimum detectable effect, and mark the nominal value."""
    axes.axvspan(-1, 1, color=HIDDEN, lw=0, label=BELOW_MINIMUM)
    axes.axvline(0, color=INK, lw=1)


def draw_departure(
    axes: Axes, row: float, cause: Cause, verdict: Verdict, *, line: float, mark: float
) -> float | None:
    """Draw the departure of a cause with its interval; return the interval's upper end.

    A cause that is not identifiable with the simulator's own parameters free has no minimum
    detectable effect; nothing is drawn, and None returned. The widths of the interval's line and of
    the estimate's mark are in points.
    """
    size = verdict.minimum_detectable.get(cause.identity)
    if size is None:
        return None
    low, middle, high = (
        (value - cause.nominal) / size
        for value in (cause.interval[0], cause.estimate, cause.interval[1])
    )
    colour = KIND_COLOURS[cause.kind]
    axes.plot([low, high], [row, row], color=colour, lw=line, solid_capstyle="butt")
    axes.plot(middle, row, "o", color=colour, ms=mark, label=KIND_NAMES[cause.kind])
    return high


def camera_figure(verdict: Verdict, positions: Floats) -> ReportFigure:
    """Draw the cameras' error on horizontal slices, where balls were measured.

    Args:
        verdict: with an error of the cameras.
        positions: (N, 3) m, where balls were measured.
    """
    lowest, highest = np.quantile(positions, [OUTERMOST, 1 - OUTERMOST], axis=0)
    across, along = (
        np.arange(np.floor(low / STEP), np.ceil(high / STEP) + 1) * STEP
        for low, high in zip(lowest[:2], highest[:2], strict=True)
    )
    slices = np.stack(np.meshgrid(across, along, HEIGHTS), axis=-1)  # (Y, X, heights, 3)
    far = np.asarray(cKDTree(positions).query(slices)[0]) > NEAR
    errors = np.where(far[..., None], np.nan, 1e3 * position_errors(verdict, slices))
    # The height in inches at which the maps fill the figure's width.
    ratio = (np.ptp(along) + 2 * STEP) / (np.ptp(across) + 2 * STEP)
    figure = Figure(figsize=(FIGURE_WIDTH, float(np.clip(0.75 + 2.1 * ratio, 3.0, 8.0))))
    panels = figure.subplots(1, len(HEIGHTS), sharex=True, sharey=True)
    largest = np.nan_to_num(np.abs(errors)).max(axis=(0, 1, 2))
    norm = Normalize(-largest[2], largest[2])
    scale = float(NICE[np.searchsorted(NICE[:-1], largest[:2].max())])
    for k, axes in enumerate(panels):
        _draw_slice(axes, across, along, errors[:, :, k], norm, scale)
        axes.set_title(f"z = {HEIGHTS[k]:g} m")
    panels[0].set_ylabel("y (m)")
    colours = ScalarMappable(norm, COLOURS)
    figure.colorbar(colours, ax=list(panels), label="error in z (mm)", shrink=0.8)
    return ReportFigure(
        figure,
        "camera",
        title="Error of the cameras over space",
        caption="Measured less true position, estimated together with the causes, at three heights "
        f"above the table. Arrows: error in x and y; the one above a map is {scale:g} mm long. "
        f"Colours: error in z. Drawn within {NEAR:g} m of measured balls; the rectangle is the "
        "table.",
    )


def position_errors(verdict: Verdict, positions: Floats) -> Floats:
    """Return (..., 3) m by how much the cameras of a verdict misplace balls; zero without any."""
    sizes = [cause.estimate for cause in verdict.causes if cause.effect == CAMERA]
    if verdict.camera is None or not sizes:
        return np.zeros_like(positions)
    nodes = [list(row) for row in verdict.camera.nodes]
    camera = {"amplitude": sizes[0], "length": verdict.camera.length, "nodes": nodes}
    return measured_positions(Simulator.from_dict({CAMERA: camera}), positions) - positions


def _draw_slice(
    axes: Axes, across: Floats, along: Floats, error: Floats, norm: Normalize, scale: float
) -> None:
    axes.pcolormesh(across, along, error[..., 2], cmap=COLOURS, norm=norm)
    corner = -TABLE_HALF_WIDTH, -TABLE_HALF_LENGTH
    axes.add_patch(
        Rectangle(corner, 2 * TABLE_HALF_WIDTH, 2 * TABLE_HALF_LENGTH, fill=False, ec=MUTED)
    )
    shown = slice(None, None, ARROW_EVERY)
    arrows = axes.quiver(
        across[shown],
        along[shown],
        error[shown, shown, 0],
        error[shown, shown, 1],
        angles="xy",
        scale_units="xy",
        scale=scale / ARROW,
        color=INK,
        width=0.006,
    )
    axes.quiverkey(
        arrows, 0.85, 1.02, scale, f"{scale:g} mm", labelpos="N", fontproperties={"size": 7}
    )
    axes.set_aspect("equal")
    axes.grid(visible=False)
    axes.set_xlabel("x (m)")


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
    right.axhline(0, color=INK, lw=1)
    for direction, (name, colour) in enumerate(DIRECTIONS.items()):
        mean, margin = 1000 * located.means[:, direction], 1000 * located.margins[:, direction]
        right.fill_between(times[1:], mean - margin, mean + margin, color=colour, alpha=0.2, lw=0)
        right.plot(times[1:], mean, color=colour, label=name)
    low, high = right.get_ylim()
    right.set_ylim(low, high + 0.15 * (high - low))
    right.set_ylabel("mean discrepancy (mm)")
    right.set_title("Mean of all shots, by direction")
    for axes in (left, right):
        axes.set_xlim(0, times[-1])
        axes.set_xlabel("prediction horizon (ms)")
    left.set_ylim(0, max(1.15 * float(np.sum(bands, axis=0).max()), 1.0))
    # In the order in which bands lie above one another.
    left.legend(*(part[::-1] for part in left.get_legend_handles_labels()), loc="upper left")
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
    shown = located.growth[:MOST_COVARIATES]
    figure = Figure(figsize=(FIGURE_WIDTH, GROWTH_HEIGHT))
    grid = figure.subplots(len(DIRECTIONS), len(shown), squeeze=False, sharey=True, sharex="col")
    for column, growth in enumerate(shown):
        positions = range(len(growth.kinds)) if growth.kinds else growth.centres
        for row, colour in enumerate(DIRECTIONS.values()):
            _draw_growth(grid[row, column], growth, positions, row, colour)
        title = f"share {percent(growth.share)}, {p_text(growth.p_value)}"
        grid[0, column].set_title(title, loc="left", fontsize=8)
        unit = f" ({growth.unit})" if growth.unit else ""
        grid[-1, column].set_xlabel(f"{growth.covariate}{unit}")
        if growth.kinds:
            names = [name.replace(" ", "\n") for name in growth.kinds]
            grid[-1, column].set_xticks(positions, names, fontsize=7)
        else:
            grid[-1, column].locator_params(axis="x", nbins=4)
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


def _draw_growth(
    axes: Axes, growth: Growth, positions: Sequence[float] | Floats, direction: int, colour: str
) -> None:
    axes.axhline(0, color=INK, lw=1)
    axes.errorbar(
        positions,
        1000 * growth.means[:, direction],
        1000 * growth.margins[:, direction],
        fmt="o" if growth.kinds else "o-",
        color=colour if growth.p_value <= SIGNIFICANT else MUTED,
        ms=4,
        lw=1.2,
        elinewidth=1.2,
    )
    axes.margins(x=0.25 if growth.kinds else 0.1)
