"""Recordings over time with the contacts that segmentation found, as small multiples."""

from collections.abc import Sequence

import pandas as pd
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D

from pipeline.io.figure_style import CONTACT_COLOURS, FIGURE_WIDTH, INK

COLUMNS = 4
CELL_HEIGHT = 2.3  # inch, of one recording: height above, length below
HEADROOM = 0.5  # inch, for the legend
OUTLIER_COLOUR = "#c94f6d"
PALE = "#c2c9ce"
SHOWN_SECONDS = 4.0  # of each recording; games go on and on
DRAWN = {"pz": "z (m)", "py": "y (m)"}


def cuts_figure(
    recordings: pd.DataFrame, samples: pd.DataFrame, contacts: pd.DataFrame, chosen: Sequence[str]
) -> Figure:
    """Draw how the chosen recordings begin: height and length of every sample, and every contact.

    Args:
        recordings: measured samples, also of recordings that are not chosen.
        samples: those in an episode; the others are drawn pale.
        contacts: where paths break.
        chosen: ids of the recordings to draw, in the order of drawing; at least one.
    """
    rows = -(-len(chosen) // COLUMNS)
    figure = Figure(figsize=(FIGURE_WIDTH, HEADROOM + CELL_HEIGHT * rows))
    grid = figure.subplots(2 * rows, COLUMNS, squeeze=False)
    for axes in grid.flat:
        axes.set_axis_off()
    for number, recording_id in enumerate(chosen):
        row, column = divmod(number, COLUMNS)
        cell = list(grid[2 * row : 2 * row + 2, column])
        own = recordings[recordings["recording_id"] == recording_id]
        end = own["t"].iloc[0] + SHOWN_SECONDS
        tables = [
            table[(table["recording_id"] == recording_id) & (table["t"] < end)]
            for table in (own, samples, contacts)
        ]
        _draw_recording(cell, *tables)
        cell[0].set_title(recording_id.split("/", 1)[1], fontsize="small")
    for axes in grid[:, 0]:
        axes.yaxis.label.set_visible(True)
    figure.supxlabel("time since the recording began (s)", fontsize="medium")
    figure.legend(handles=_legend(), loc="outside upper center", ncols=6, handletextpad=0.4)
    return figure


def _draw_recording(
    cell: list[Axes], recording: pd.DataFrame, samples: pd.DataFrame, contacts: pd.DataFrame
) -> None:
    begin = recording["t"].iloc[0]
    outliers = samples[samples["outlier"]]
    for axes, (column, label) in zip(cell, DRAWN.items(), strict=True):
        axes.set_axis_on()
        for kind, time in zip(contacts["kind"], contacts["t"], strict=True):
            axes.axvline(time - begin, color=CONTACT_COLOURS[kind], lw=1.2)
        axes.plot(recording["t"] - begin, recording[column], ".", color=PALE, ms=2.5, mew=0)
        axes.plot(samples["t"] - begin, samples[column], ".", color=INK, ms=2.5, mew=0)
        axes.plot(outliers["t"] - begin, outliers[column], "x", ms=4, color=OUTLIER_COLOUR)
        axes.set_ylabel(label, visible=False)
        axes.locator_params(nbins=3)
    cell[0].tick_params(labelbottom=False)


def _legend() -> list[Line2D]:
    lines = [Line2D([], [], color=colour, label=kind) for kind, colour in CONTACT_COLOURS.items()]
    cross = Line2D([], [], color=OUTLIER_COLOUR, marker="x", ls="", label="outlier")
    pale = Line2D([], [], color=PALE, marker=".", ls="", label="in no episode")
    return [*lines, cross, pale]
