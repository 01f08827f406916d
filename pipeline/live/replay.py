"""Replay: recordings from files, as if they came from cameras."""

import time
from collections.abc import Iterable, Iterator

import numpy as np
import pandas as pd

from rallygap.pipeline.io.schemas import POSITION_COLUMNS, SPIN_COLUMNS
from rallygap.pipeline.live.messages import Measurement

PAUSE = 1.0  # s on the clock between two recordings


def measurements(parts: Iterable[pd.DataFrame]) -> Iterator[Measurement]:
    """Yield the rows of recordings, one recording after the other on one clock.

    Args:
        parts: rows of ``RECORDINGS``, each with whole recordings.
    """
    number, now = 0, 0.0
    for part in parts:
        for _, rows in part.groupby("recording_id", sort=False):
            times = rows["t"].to_numpy(dtype=np.float64)
            times = now + times - times[0]
            places = rows[POSITION_COLUMNS].to_numpy(dtype=np.float64)
            spins = rows[SPIN_COLUMNS].to_numpy(dtype=np.float64)
            for t, place, spin in zip(times.tolist(), places, spins, strict=True):
                yield Measurement(number, t, place, spin if np.isfinite(spin).all() else None)
                number += 1
            now = float(times[-1]) + PAUSE


def paced(rows: Iterable[Measurement], speed: float) -> Iterator[Measurement]:
    """Yield measurements when they are due, ``speed`` times as fast as they were recorded."""
    zero = None  # when the recording's time zero is, on the clock of this process
    for row in rows:
        if zero is None:
            zero = time.monotonic() - row.time / speed
        time.sleep(max(zero + row.time / speed - time.monotonic(), 0.0))
        yield row
