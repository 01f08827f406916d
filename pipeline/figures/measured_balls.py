"""Measured balls over the table, from the side and from above, one row of panels a source."""

import numpy as np
import pandas as pd
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.patches import Rectangle

from models.ball.state import (
    NET_HEIGHT,
    NET_OVERHANG,
    TABLE_HALF_LENGTH,
    TABLE_HALF_WIDTH,
)
from pipeline.contracts import POSITION_COLUMNS, VELOCITY_COLUMNS
from pipeline.figures.style import FIGURE_WIDTH, INK, MUTED

BALL_COLOUR = "#0f7fc4"
TABLE_COLOUR = "#dfe9e4"
DRAWN_BALLS = 20_000  # of a source, evenly chosen; more only darken the panel
DRAWN_LAUNCHES = 600
LAUNCH_SECONDS = 0.03  # of flight that a launch's arrow stands for
PANEL_HEIGHT = 2.2  # inch
VIEWS = {"from the side": (1, 2), "from above": (1, 0)}  # the axes drawn across and up
AXIS_LABELS = ["x (m)", "y (m)", "z (m)"]
LIMITS = [(-1.3, 1.3), (-2.4, 2.4), (-0.9, 1.7)]  # m


def measured_balls_figure(sources: dict[str, pd.DataFrame]) -> Figure:
    """Draw the measured positions of every source, with table and net.

    Args:
        sources: name -> positions (columns px, py, pz; m, table frame). Where velocities (vx, vy,
            vz; m/s) are there too, each row is a launch and drawn as an arrow.
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
    is_launch = VELOCITY_COLUMNS[0] in balls
    drawn = _evenly_chosen(balls, DRAWN_LAUNCHES if is_launch else DRAWN_BALLS)
    start = drawn[POSITION_COLUMNS].to_numpy()
    axes.plot(start[:, along], start[:, up], ".", ms=1.8, alpha=0.5, mew=0, color=BALL_COLOUR)
    if is_launch:
        end = start + LAUNCH_SECONDS * drawn[VELOCITY_COLUMNS].to_numpy()
        across, upwards = np.stack([start, end])[:, :, [along, up]].transpose(2, 0, 1)
        axes.plot(across, upwards, color=BALL_COLOUR, lw=0.6, alpha=0.4)


def _evenly_chosen(balls: pd.DataFrame, most: int) -> pd.DataFrame:
    chosen = np.unique(np.linspace(0, len(balls) - 1, min(most, len(balls))).round().astype(int))
    return balls.iloc[chosen]
