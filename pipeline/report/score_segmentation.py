"""The report of `score_segmentation`: detected contacts, their time errors, missed ones."""

from collections.abc import Iterator
from typing import Any

import numpy as np
import pandas as pd
from matplotlib.figure import Figure

from rallygap.pipeline.runtime.stage_run import StageRun
from rallygap.pipeline.web.figure_style import CONTACT_COLOURS, FIGURE_WIDTH
from rallygap.pipeline.web.report_items import ReportFigure, ReportItem, ReportTable

LARGEST_ERROR = 5.0  # ms, that is drawn
ERROR_BINS = np.linspace(-LARGEST_ERROR, LARGEST_ERROR, 101)
SPEEDS = {"table": "bounce: vertical speed after it", "racket": "racket: speed after it"}


def items(run: StageRun) -> Iterator[ReportItem]:
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
