"""Map of the position-dependent camera error, on horizontal slices."""

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
from rallygap.models.gap.verdict import Verdict
from rallygap.pipeline.web.figure_style import FIGURE_WIDTH, INK, MUTED
from rallygap.pipeline.web.report_items import ReportFigure

CAMERA = "camera_distortion"
HEIGHTS = (0.1, 0.3, 0.6)  # m above the table
STEP = 0.1  # m, of the map; there is an arrow at every third place
ARROW_EVERY = 3
NEAR = 0.15  # m, from a measured ball: farther away nothing is known
OUTERMOST = 0.005  # share of the balls on each side that the map leaves out
ARROW = 0.25  # m on the map, of an error as large as the scale says
COLOURS = "RdBu_r"
NICE = np.array([0.5, 1.0, 2.0, 5.0, 10.0, 20.0, 50.0])  # mm


def camera_figure(verdict: Verdict, places: Floats) -> ReportFigure:
    """Draw the cameras' error where balls were measured.

    Args:
        verdict: with an error of the cameras.
        places: (N, 3) m, where balls were measured.
    """
    across, along = (_axis(places[:, axis]) for axis in (0, 1))
    errors = [_errors(verdict, places, across, along, height) for height in HEIGHTS]
    figure = Figure(figsize=(FIGURE_WIDTH, _height(across, along)))
    panels = figure.subplots(1, len(HEIGHTS), sharex=True, sharey=True)
    largest = np.nan_to_num(np.abs(errors)).max(axis=(0, 1, 2))
    norm = Normalize(-largest[2], largest[2])
    scale = float(NICE[np.searchsorted(NICE[:-1], largest[:2].max())])
    for axes, height, error in zip(panels, HEIGHTS, errors, strict=True):
        _draw_slice(axes, across, along, error, norm, scale)
        axes.set_title(f"z = {height:g} m")
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


def position_errors(verdict: Verdict, places: Floats) -> Floats:
    """Return (..., 3) m by how much the cameras of a verdict misplace balls; zero without any."""
    sizes = [cause.estimate for cause in verdict.causes if cause.effect == CAMERA]
    if verdict.camera is None or not sizes:
        return np.zeros_like(places)
    nodes = [list(row) for row in verdict.camera.nodes]
    camera = {"amplitude": sizes[0], "length": verdict.camera.length, "nodes": nodes}
    errors: Floats = measured_positions(Simulator.from_dict({CAMERA: camera}), places) - places
    return errors


def _axis(values: Floats) -> Floats:
    low, high = np.quantile(values, [OUTERMOST, 1 - OUTERMOST])
    return np.arange(np.floor(low / STEP), np.ceil(high / STEP) + 1) * STEP


def _errors(
    verdict: Verdict, places: Floats, across: Floats, along: Floats, height: float
) -> Floats:
    """Return (Y, X, 3) mm on a slice, NaN far from all measured balls."""
    x, y = np.meshgrid(across, along)
    slice_places = np.stack([x, y, np.full_like(x, height)], axis=-1)
    distances = np.asarray(cKDTree(places).query(slice_places)[0])
    errors = 1e3 * position_errors(verdict, slice_places)
    shown: Floats = np.where(distances[..., None] <= NEAR, errors, np.nan)
    return shown


def _height(across: Floats, along: Floats) -> float:
    """Return the height in inches at which the maps fill the figure's width."""
    width = np.ptp(across) + 2 * STEP
    return float(np.clip(0.75 + 2.1 * (np.ptp(along) + 2 * STEP) / width, 3.0, 8.0))


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
