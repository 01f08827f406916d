"""How well contacts are found: errors of their times, and at which speeds contacts are missed."""

import numpy as np
import pandas as pd
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from pipeline.io.figure_style import CONTACT_COLOURS, FIGURE_WIDTH

LARGEST_ERROR = 5.0  # ms, that is drawn
ERROR_BINS = np.linspace(-LARGEST_ERROR, LARGEST_ERROR, 101)
SPEEDS = {"table": "bounce: vertical speed after it", "racket": "racket: speed after it"}


def contact_scores_figure(contacts: pd.DataFrame) -> Figure:
    """Draw the errors of the times of contacts, and over the speed, with those that were missed.

    Args:
        contacts: true contacts that can be seen: ``kind``, ``speed`` (m/s), ``found``, ``error``
            (s); without any the axes stay empty.
    """
    figure = Figure(figsize=(FIGURE_WIDTH, 3.0))
    share_axes, speed_axes = figure.subplots(1, 2)
    for kind, members in contacts.groupby("kind", sort=True):
        colour = CONTACT_COLOURS[str(kind)]
        errors = 1e3 * members["error"].dropna()
        weights = np.full(len(errors), 1 / max(len(errors), 1))
        share_axes.hist(
            errors, ERROR_BINS, weights=weights, histtype="step", lw=1.8, color=colour, label=kind
        )
        _draw_by_speed(speed_axes, members, colour, SPEEDS[str(kind)])
    share_axes.set(xlabel="time found less true time (ms)", ylabel="share of the contacts")
    speed_axes.set(xlabel="speed (m/s)", ylabel="time found less true time (ms)")
    speed_axes.set_ylim(-1.1 * LARGEST_ERROR, 1.1 * LARGEST_ERROR)
    if len(contacts):
        share_axes.legend()
        speed_axes.legend(loc="upper right")
    return figure


def _draw_by_speed(axes: Axes, contacts: pd.DataFrame, colour: str, label: str) -> None:
    missed = contacts[~contacts["found"]]
    axes.plot(contacts["speed"], 1e3 * contacts["error"], ".", color=colour, label=label, ms=3)
    axes.plot(missed["speed"], np.full(len(missed), -LARGEST_ERROR), "x", color=colour, ms=5)
