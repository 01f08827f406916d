"""Raw recordings as arrays, in the table frame as their source states it."""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace

import numpy as np
import pandas as pd

from rallygap.models.ball.types import Floats
from rallygap.models.gap.fit.shots import spread_evenly
from rallygap.pipeline.io.frame import Frame
from rallygap.pipeline.io.schemas import POSITION_COLUMNS, SPIN_COLUMNS
from rallygap.pipeline.sources.source import SAMPLE_COLUMNS, RawTable

MOST = 150  # recordings that are checked, spread evenly over all
FEWEST_SAMPLES = 8


@dataclass(frozen=True)
class Track:
    """The samples of one recording, before any of them is refused as implausible.

    Attributes:
        times: (n,) s, rising.
        positions: (n, 3) m.
        spins: (n, 3) rad/s, NaN where there is no label.
    """

    times: Floats
    positions: Floats
    spins: Floats

    def in_units(self, second: float, metre: float) -> "Track":
        """Return the track with so many of its own units to a second and to a metre."""
        return replace(self, times=self.times / second, positions=self.positions / metre)

    def turned(self, axes: Floats) -> "Track":
        """Return the track with positions and spins multiplied by a (3, 3) matrix."""
        return replace(self, positions=self.positions @ axes.T, spins=self.spins @ axes.T)


def tracks_of(tables: Sequence[RawTable], frame: Frame) -> list[Track]:
    """Return the recordings that have enough samples with numbers, at most ``MOST``."""
    chosen = [tables[k] for k in spread_evenly(len(tables), min(MOST, len(tables)))]
    return list(_tracks(chosen, frame))


def _tracks(tables: Sequence[RawTable], frame: Frame) -> Iterator[Track]:
    for table in tables:
        rows = table.rows.reindex(columns=SAMPLE_COLUMNS).astype(float)
        rows = rows[np.isfinite(rows[["t", *POSITION_COLUMNS]].to_numpy()).all(axis=1)]
        rises = rows["t"] > rows["t"].cummax().shift(fill_value=-np.inf)
        rows = frame.to_table(rows[rises])
        if len(rows) >= FEWEST_SAMPLES:
            spins = _once(rows[SPIN_COLUMNS].to_numpy())
            yield Track(rows["t"].to_numpy(), rows[POSITION_COLUMNS].to_numpy(), spins)


def _once(spins: Floats) -> Floats:
    """Return labels, of which one that is repeated in every row holds for the first row only."""
    labels = pd.DataFrame(spins).dropna()
    if len(labels) > 1 and (labels == labels.iloc[0]).all(axis=None):
        spins = spins.copy()
        spins[labels.index[1] :] = np.nan
    return spins
