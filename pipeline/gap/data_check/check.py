"""The check of recordings before any verdict: units, axes, heights, time stamps, spin labels.

``doubts`` says what is doubtful about what was measured. Each doubt has the line of source.yaml
that corrects it, where one does.
"""

from collections.abc import Iterator, Sequence
from pathlib import Path

import numpy as np

from rallygap.models.ball.types import Floats
from rallygap.pipeline.gap.data_check import geometry
from rallygap.pipeline.gap.data_check.doubt import Doubt, Setup
from rallygap.pipeline.gap.data_check.measured import Measured, Track
from rallygap.pipeline.gap.data_check.spins import impossible_spins, spin_doubts
from rallygap.pipeline.io.frame import Frame
from rallygap.pipeline.runtime.errors import InputError
from rallygap.pipeline.sources.conversion import Conversion
from rallygap.pipeline.sources.source import RawTable

ROUNDED = 1e-3  # s
ROUNDING_ERROR = 1e-6  # s, of a time stamp that is a multiple of ROUNDED
FEWEST_SPEEDS = 5  # recordings whose speeds are compared
SAME_SPEED = 0.05  # relative standard deviation of the speeds of recordings


def check_recordings(
    tables: Sequence[RawTable], frame: Frame, conversion: Conversion | None, folder: Path
) -> tuple[str, ...]:
    """Return what is doubtful about raw recordings, one sentence each, without a full stop.

    Args:
        tables: recordings as the source reads them.
        frame: their transformation into the table frame.
        conversion: axes and units that source.yaml states; ``None`` for a source without one.
        folder: of the files, for messages.

    Raises:
        InputError: something cannot be right. The message has the line of source.yaml that
            corrects it.
    """
    unusual = []
    for doubt in doubts(Measured.by(tables, frame), Setup(frame, conversion)):
        if doubt.impossible:
            advice = f"; source.yaml needs the line `{doubt.line}`" if doubt.line else ""
            raise InputError(folder, f"{doubt.text}{advice}")
        unusual.append(doubt.text)
    return tuple(unusual)


def doubts(measured: Measured, setup: Setup) -> Iterator[Doubt]:
    """Yield what is doubtful: first what is impossible, from units to spin labels.

    What follows an impossible one assumes that it is corrected, so that a reader stops there.

    Args:
        measured: by the recordings.
        setup: of their source.
    """
    if not measured.tracks:
        return
    yield from geometry.impossible_units(measured, setup)
    yield from geometry.impossible_axes(measured, setup)
    yield from geometry.impossible_heights(measured, setup)
    yield from impossible_spins(measured.flights, setup)
    yield from geometry.fall_doubts(measured)
    yield from geometry.height_doubts(measured)
    yield from spin_doubts(measured.flights)
    yield from geometry.origin_doubts(measured)
    yield from _sample_doubts(measured)


def _sample_doubts(measured: Measured) -> Iterator[Doubt]:
    """Yield what is unusual about time stamps and speeds."""
    if all(_is_rounded(track.times) for track in measured.tracks):
        yield Doubt(
            "time stamps are rounded to 1 ms: fast balls move by several millimetres in that time"
        )
    speeds = np.array([_speed(track) for track in measured.tracks])
    if len(speeds) >= FEWEST_SPEEDS and speeds.std() < SAME_SPEED * speeds.mean():
        yield Doubt(
            f"all shots have about the same speed, {speeds.mean():.1f} m/s: effects that depend on "
            "speed are not identifiable; record several speeds"
        )


def _is_rounded(times: Floats) -> bool:
    """Return whether time stamps are whole milliseconds while frames are not."""
    steps = np.diff(times)
    whole = np.abs(times - np.round(times / ROUNDED) * ROUNDED) < ROUNDING_ERROR
    return bool(whole.all() and np.ptp(steps) > ROUNDED / 2)


def _speed(track: Track) -> float:
    """Return the median speed over several samples, m/s."""
    lag = max(len(track.times) // 10, 1)
    steps = np.linalg.norm(track.positions[lag:] - track.positions[:-lag], axis=1)
    return float(np.median(steps / (track.times[lag:] - track.times[:-lag])))
