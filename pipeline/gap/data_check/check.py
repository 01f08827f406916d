"""The check of recordings: impossible data raise an error, doubtful data are reported."""

from collections.abc import Sequence
from pathlib import Path

import numpy as np

from rallygap.pipeline.gap.data_check.axes import axes_problem
from rallygap.pipeline.gap.data_check.bounces import bounce_places
from rallygap.pipeline.gap.data_check.doubts import doubts_of
from rallygap.pipeline.gap.data_check.fall import Fall, fall_of
from rallygap.pipeline.gap.data_check.flights import flights_of
from rallygap.pipeline.gap.data_check.heights import height_problem
from rallygap.pipeline.gap.data_check.problem import Problem, Setup
from rallygap.pipeline.gap.data_check.spins import spin_problem
from rallygap.pipeline.gap.data_check.tracks import Track, tracks_of
from rallygap.pipeline.gap.data_check.units import (
    fall_problem,
    length_scale,
    time_scale,
    unit_problem,
)
from rallygap.pipeline.io.frame import Frame
from rallygap.pipeline.runtime.errors import InputError
from rallygap.pipeline.sources.conversion import Conversion
from rallygap.pipeline.sources.source import RawTable

UP = np.array([0.0, 0.0, 1.0])


def check_recordings(
    tables: Sequence[RawTable], frame: Frame, conversion: Conversion | None, folder: Path
) -> tuple[str, ...]:
    """Check units, axes, heights and spin labels of raw recordings.

    Args:
        tables: recordings as the source reads them.
        frame: their transformation into the table frame.
        conversion: axes and units that source.yaml states; ``None`` for a source without one.
        folder: of the files, for messages.

    Returns:
        What is doubtful, one sentence each, without a full stop.

    Raises:
        InputError: something cannot be right. The message has the line of source.yaml that
            corrects it.
    """
    tracks = tracks_of(tables, frame)
    if not tracks:
        return ()
    setup = Setup(frame, conversion)
    fall = _checked_units(tracks, setup, folder)
    flights = flights_of(tracks)
    if fall is not None:
        _stop(axes_problem(fall, flights, setup), folder)
    places = bounce_places(flights.contacts, UP)
    _stop(height_problem(places, setup), folder)
    _stop(spin_problem(flights, setup), folder)
    return tuple(doubts_of(tracks, fall, flights, places))


def _checked_units(tracks: Sequence[Track], setup: Setup, folder: Path) -> Fall | None:
    """Return how the ball falls; ``None`` if the tracks are too short to say."""
    second = time_scale(tracks)
    timed = [track.in_units(second, 1.0) for track in tracks]
    fall = fall_of(timed)
    metre = 1.0 if fall is None else length_scale(timed, fall, setup)
    _stop(unit_problem(tracks, second, metre, setup), folder)
    if fall is not None:
        _stop(fall_problem(fall), folder)
    return fall


def _stop(problem: Problem | None, folder: Path) -> None:
    if problem is None:
        return
    advice = f"; source.yaml needs the line `{problem.line}`" if problem.line else ""
    raise InputError(folder, f"{problem.text}{advice}")
