"""The reports of `segment` and `score_segmentation`: contacts, their errors, and the splits."""

from collections.abc import Iterator, Sequence
from typing import Any

import numpy as np
import pandas as pd
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D

from rallygap.models.segmentation.split import recording_groups
from rallygap.pipeline.io.schemas import EPISODES, read_checked
from rallygap.pipeline.runtime.stage_run import StageRun
from rallygap.pipeline.web.figure_style import CONTACT_COLOURS, FIGURE_WIDTH, INK
from rallygap.pipeline.web.report_items import ReportFigure, ReportItem, ReportTable

COLUMNS = 4
CELL_HEIGHT = 2.3  # inch, of one recording: height above, length below
HEADROOM = 0.5  # inch, for the legend
OUTLIER_COLOUR = "#c94f6d"
PALE = "#c2c9ce"
SHOWN_SECONDS = 4.0  # of each recording
LARGEST_ERROR = 5.0  # ms, that is drawn
ERROR_BINS = np.linspace(-LARGEST_ERROR, LARGEST_ERROR, 101)
SPEEDS = {"table": "bounce: vertical speed after it", "racket": "racket: speed after it"}
DRAWN = {"pz": "z (m)", "py": "y (m)"}


def items(run: StageRun) -> Iterator[ReportItem]:
    """Yield the recordings of every source that were drawn at random, and the splits."""
    names = ("drawn_recordings", "drawn_samples", "drawn_contacts")
    recordings, samples, contacts = (run.kept("segment", name) for name in names)
    chosen = recordings["recording_id"].drop_duplicates().sort_values()
    for source, members in chosen.groupby(chosen.str.partition("/")[0], sort=True):
        yield cuts_figure(str(source), recordings, samples, contacts, list(members))
    yield splits_table(read_checked(run.input("segment", "episodes.parquet"), EPISODES))


def cuts_figure(
    source: str,
    recordings: pd.DataFrame,
    samples: pd.DataFrame,
    contacts: pd.DataFrame,
    chosen: Sequence[str],
) -> ReportFigure:
    """Draw the first seconds of the chosen recordings: samples and contacts.

    Args:
        source: of the recordings.
        recordings: measured samples.
        samples: samples in an episode; the others are drawn in grey.
        contacts: detected contacts.
        chosen: ids of the recordings to draw, in the order of drawing; at least one.
    """
    rows = -(-len(chosen) // COLUMNS)
    figure = Figure(figsize=(FIGURE_WIDTH, HEADROOM + CELL_HEIGHT * rows))
    grid = figure.subplots(2 * rows, COLUMNS, squeeze=False)
    for axes in grid.flat:
        axes.set_axis_off()
    for number, recording_id in enumerate(chosen):
        row, column = divmod(number, COLUMNS)
        own = [
            table[table["recording_id"] == recording_id]
            for table in (recordings, samples, contacts)
        ]
        start = own[0]["t"].iloc[0]
        shown = [table[table["t"] < start + SHOWN_SECONDS] for table in own]
        shown = [table.assign(t=table["t"] - start) for table in shown]
        cell = list(grid[2 * row : 2 * row + 2, column])
        _draw_recording(cell, *shown)
        cell[0].set_title(recording_id.split("/", 1)[1], fontsize="small")
    for axes in grid[:, 0]:
        axes.yaxis.label.set_visible(True)
    figure.supxlabel("time since the first sample (s)", fontsize="medium")
    lines = [Line2D([], [], color=colour, label=kind) for kind, colour in CONTACT_COLOURS.items()]
    lines.append(Line2D([], [], color=OUTLIER_COLOUR, marker="x", ls="", label="outlier"))
    lines.append(Line2D([], [], color=PALE, marker=".", ls="", label="in no episode"))
    figure.legend(handles=lines, loc="outside upper center", ncols=6, handletextpad=0.4)
    return ReportFigure(
        figure,
        f"cuts_{source}",
        title=f"Contacts in recordings of {source}",
        caption=f"{len(chosen)} recordings drawn at random: height above the table (z) and "
        f"position along it (y) in the first {SHOWN_SECONDS:g} s. Vertical lines are "
        "detected contacts.",
    )


def _draw_recording(
    cell: Sequence[Axes], recording: pd.DataFrame, samples: pd.DataFrame, contacts: pd.DataFrame
) -> None:
    outliers = samples[samples["outlier"]]
    for axes, (column, label) in zip(cell, DRAWN.items(), strict=True):
        axes.set_axis_on()
        for kind, time in zip(contacts["kind"], contacts["t"], strict=True):
            axes.axvline(time, color=CONTACT_COLOURS[kind], lw=1.2)
        axes.plot(recording["t"], recording[column], ".", color=PALE, ms=2.5, mew=0)
        axes.plot(samples["t"], samples[column], ".", color=INK, ms=2.5, mew=0)
        axes.plot(outliers["t"], outliers[column], "x", ms=4, color=OUTLIER_COLOUR)
        axes.set_ylabel(label, visible=False)
        axes.locator_params(nbins=3)
    cell[0].tick_params(labelbottom=False)


def splits_table(episodes: pd.DataFrame) -> ReportTable:
    """Return the number of episodes and recordings of each source, group, split and replay set."""
    keys = [episodes["source"], recording_groups(episodes["recording_id"]).rename("group")]
    keys += [episodes["split"], episodes["replay_set"]]
    counts = episodes.groupby(keys)["recording_id"].agg(episodes="size", recordings="nunique")
    return ReportTable(
        counts.reset_index(),
        "splits",
        title="Splits",
        caption="Number of episodes and recordings in each split. A recording belongs to one "
        "split as a whole. Not every episode of a replay recording is in a replay set.",
    )


def score_items(run: StageRun) -> Iterator[ReportItem]:
    """Yield precision and recall, and the time errors."""
    settings = run.params.score_segmentation
    yield ReportTable(
        run.kept("score_segmentation", "contacts"),
        "contacts",
        title="Detected contacts",
        caption="Contacts of test recordings while the ball is in play. A contact is detected if "
        f"one of the same kind is detected within {1e3 * settings.tolerance:g} ms. Precision and "
        f"recall count contacts with at least {settings.fewest_samples} samples within "
        f"{1e3 * settings.reach:g} ms on each side and no other contact between; the others are "
        "listed as hidden.",
    )
    yield contact_scores_figure(run.kept("score_segmentation", "observable"))


def contact_scores_figure(contacts: pd.DataFrame) -> ReportFigure:
    """Draw the time errors of contacts: histogram, and over the speed with the missed contacts.

    Args:
        contacts: true observable contacts: ``kind``, ``speed`` (m/s), ``detected``, ``error``
            (s); without any the axes stay empty.
    """
    figure = Figure(figsize=(FIGURE_WIDTH, 3.0))
    left, right = figure.subplots(1, 2)
    for kind, members in contacts.groupby("kind", sort=True):
        colour = CONTACT_COLOURS[str(kind)]
        errors = 1e3 * members["error"].dropna()
        weights = np.full(len(errors), 1 / max(len(errors), 1))
        style: dict[str, Any] = {"histtype": "step", "lw": 1.8, "color": colour, "label": kind}
        left.hist(errors, ERROR_BINS, weights=weights, **style)
        missed = members.loc[~members["detected"], "speed"]
        style = {"color": colour, "label": SPEEDS[str(kind)], "ms": 3}
        right.plot(members["speed"], 1e3 * members["error"], ".", **style)
        right.plot(missed, np.full(len(missed), -LARGEST_ERROR), "x", color=colour, ms=5)
    left.set(xlabel="detected - true time (ms)", ylabel="share of contacts")
    right.set(xlabel="speed (m/s)", ylabel="detected - true time (ms)")
    right.set_ylim(-1.1 * LARGEST_ERROR, 1.1 * LARGEST_ERROR)
    if len(contacts):
        left.legend()
        right.legend(loc="upper right")
    return ReportFigure(
        figure,
        "contact_scores",
        title="Time errors of detected contacts",
        caption="Racket contacts and bounces of test recordings. Left: histogram of the time "
        "errors. Right: time error over the speed; a cross is a contact that is not detected.",
    )
