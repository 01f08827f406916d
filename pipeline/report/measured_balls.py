"""Measured trajectories over the table, from the side and from above, a row of panels each."""

import numpy as np
import pandas as pd
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.patches import Rectangle
from numpy.typing import NDArray

from rallygap.models.ball.state import (
    NET_HEIGHT,
    NET_OVERHANG,
    TABLE_HALF_LENGTH,
    TABLE_HALF_WIDTH,
)
from rallygap.pipeline.io.schemas import POSITION_COLUMNS, VELOCITY_COLUMNS
from rallygap.pipeline.web.figure_style import FIGURE_WIDTH, INK, MUTED

BALL_COLOUR = "#0f7fc4"
TABLE_COLOUR = "#dfe9e4"
DRAWN_BALLS = 20_000  # of a source; more only darken the panel
DRAWN_RUN = 200  # successive balls, that paths can be seen
DRAWN_LAUNCHES = 600
LAUNCH_SECONDS = 0.03  # of flight that a launch's arrow stands for
PANEL_HEIGHT = 2.2  # inch
VIEWS = {"from the side": (1, 2), "from above": (1, 0)}  # the axes drawn across and up
AXIS_LABELS = ["x (m)", "y (m)", "z (m)"]
LIMITS = [(-1.3, 1.3), (-2.4, 2.4), (-0.9, 1.7)]  # m


def drawn_rows(rows: int, *, launches: bool) -> NDArray[np.int64]:
    """Return which of a source's rows to draw, ascending: evenly chosen launches or runs of balls.

    Args:
        rows: how many there are.
        launches: whether they are launches; successive ones have nothing to do with each other.
    """
    run, most = (1, DRAWN_LAUNCHES) if launches else (DRAWN_RUN, DRAWN_BALLS)
    if rows <= most:
        return np.arange(rows)
    starts = np.linspace(0, rows - run, most // run).astype(np.int64)
    return (starts[:, None] + np.arange(run)).ravel()


def measured_balls_figure(sources: dict[str, pd.DataFrame]) -> Figure:
    """Draw measured positions of every source, with table and net.

    Args:
        sources: name -> positions (columns px, py, pz; m, table frame), as many as ``drawn_rows``
            says. Where velocities (vx, vy, vz; m/s) are there too, each row is a launch and drawn
            with its way.
    """
    figure = Figure(figsize=(FIGURE_WIDTH, 0.4 + PANEL_HEIGHT * len(sources)))
    grid = figure.subplots(len(sources), len(VIEWS), squeeze=False)
    for axes_row, (name, balls) in zip(grid, sources.items(), strict=True):
        for axes, (view, (along, up)) in zip(axes_row, VIEWS.items(), strict=True):
            _draw_table(axes, from_above=up == 0)
            _draw_balls(axes, balls, along, up)
            axes.set(xlabel=AXIS_LABELS[along], ylabel=AXIS_LABELS[up], aspect="equal")
            # Seen from above with y to the right, x points down.
            axes.set(xlim=LIMITS[along], ylim=LIMITS[up] if up == 2 else LIMITS[up][::-1])
            axes.set_title(view)
        axes_row[0].set_title(f"{name}, {next(iter(VIEWS))}")
    return figure


def _draw_table(axes: Axes, *, from_above: bool) -> None:
    bottom, height = (-TABLE_HALF_WIDTH, 2 * TABLE_HALF_WIDTH) if from_above else (-0.03, 0.03)
    size = (2 * TABLE_HALF_LENGTH, height)
    axes.add_patch(
        Rectangle((-TABLE_HALF_LENGTH, bottom), *size, facecolor=TABLE_COLOUR, edgecolor=MUTED)
    )
    reach = TABLE_HALF_WIDTH + NET_OVERHANG
    net = (-reach, reach) if from_above else (0, NET_HEIGHT)
    axes.plot([0, 0], net, color=INK, lw=1.2)


def _draw_balls(axes: Axes, balls: pd.DataFrame, along: int, up: int) -> None:
    start = balls[POSITION_COLUMNS].to_numpy()
    axes.plot(start[:, along], start[:, up], ".", ms=1.8, alpha=0.5, mew=0, color=BALL_COLOUR)
    if VELOCITY_COLUMNS[0] in balls:
        end = start + LAUNCH_SECONDS * balls[VELOCITY_COLUMNS].to_numpy()
        across, upwards = np.stack([start, end])[:, :, [along, up]].transpose(2, 0, 1)
        axes.plot(across, upwards, color=BALL_COLOUR, lw=0.6, alpha=0.4)
