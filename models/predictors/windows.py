"""Windows: the history before an instant of an episode, and the measured future after it.

Recordings have their own time stamps; histories lie on a 5 ms grid that ends at a measured sample.
Values between samples are interpolated, never snapped to the nearest sample: 2.5 ms are 20 mm.
The history uses no sample after its last state, and keeps outliers, which a robot cannot recognise
either; the future leaves them out.
"""

from dataclasses import dataclass

import numpy as np

from rallygap.models.ball.types import Integers
from rallygap.models.predictors.protocol import (
    FUTURE,
    FUTURE_TIMES,
    HISTORY,
    HISTORY_TIMES,
    TICK,
    Bools,
    Floats,
    History,
    concatenate_histories,
)

MAX_GAP = 0.0151  # s between two samples, for interpolation: two lost frames at 200 Hz
MIN_FUTURE = 0.100  # s of measured future in a window, at least
MIN_OBSERVED = HISTORY // 2  # measured positions in a history, at least
ROUNDING = 1e-9  # s; tolerance for equal times


@dataclass(frozen=True)
class Episode:
    """The measured samples of one episode.

    Attributes:
        times: (T,) s.
        positions: (T, 3) m.
        velocities: (T, 3) m/s, estimated from the positions; NaN where unknown.
        spins: (T, 3) rad/s; NaN where not labelled.
        outlier: (T,) True where the position is an outlier.
        arc: (T,) number of the arc between contacts that a sample lies on.
        bounces: (C,) s, the times of table contacts.
    """

    times: Floats
    positions: Floats
    velocities: Floats
    spins: Floats
    outlier: Bools
    arc: np.ndarray
    bounces: Floats


@dataclass(frozen=True)
class Windows:
    """The windows of one or more episodes.

    Attributes:
        history: B histories.
        anchors: (B,) s, the instants of the last measured states.
        future: (B, 60, 9) measured position, velocity and spin; zero where not measured.
        measured: (B, 60, 9) True where measured.
        bounced: (B, 60) whether the ball met the table between the anchor and that instant.
    """

    history: History
    anchors: Floats
    future: Floats
    measured: Bools
    bounced: Bools

    def __len__(self) -> int:
        return len(self.anchors)

    def __getitem__(self, rows: slice | Integers) -> "Windows":
        return Windows(*(part[rows] for part in vars(self).values()))


def cut_windows(episode: Episode, every: float) -> Windows:
    """Cut an episode into windows: after its first 12 ticks, then every ``every`` seconds."""
    tried = _anchors(episode, every)
    states = np.zeros((len(tried), HISTORY, 6))
    mask = np.zeros(states.shape, dtype=bool)
    for row, anchor in enumerate(tried):
        states[row], mask[row] = observed_at(episode, anchor + HISTORY_TIMES, until=anchor)
    kept = mask[:, :, :3].all(axis=2).sum(axis=1) >= MIN_OBSERVED
    anchors = tried[kept]
    future = np.zeros((len(anchors), FUTURE, 9))
    measured = np.zeros(future.shape, dtype=bool)
    for row, anchor in enumerate(anchors):
        future[row], measured[row] = measured_at(episode, anchor + FUTURE_TIMES)
    since, ahead = anchors[:, None, None], (anchors[:, None] + FUTURE_TIMES)[:, :, None]
    bounced = ((since < episode.bounces) & (episode.bounces <= ahead)).any(axis=2)
    return Windows(History(states[kept], mask[kept]), anchors, future, measured, bounced)


def concatenate_windows(parts: list[Windows]) -> Windows:
    """Return the windows of several episodes as one batch."""
    history = concatenate_histories([part.history for part in parts])
    fields = ("anchors", "future", "measured", "bounced")
    rest = [np.concatenate([getattr(part, field) for part in parts]) for field in fields]
    return Windows(history, *rest)


def _anchors(episode: Episode, every: float) -> Floats:
    first = episode.times[0] - HISTORY_TIMES[0] - TICK / 2
    last = episode.times[-1] - MIN_FUTURE
    sample = np.searchsorted(episode.times, np.arange(first, last, every))
    anchors = np.unique(episode.times[sample])
    return anchors[anchors <= last + ROUNDING]


def observed_at(episode: Episode, times: Floats, until: float = np.inf) -> tuple[Floats, Bools]:
    """Return (T, 6) measured positions and spins, outliers included, and where they are known.

    Args:
        episode: the measured samples.
        times: (T,) s, increasing.
        until: s; later samples are ignored.
    """
    known = episode.times <= until
    values = np.hstack([episode.positions, episode.spins])[known]
    return _interpolated(episode.times[known], values, times)


def measured_at(episode: Episode, times: Floats) -> tuple[Floats, Bools]:
    """Return (T, 9) positions, velocities and spins without outliers, and where they are known."""
    good = ~episode.outlier
    values = np.hstack([episode.positions, episode.velocities, episode.spins])
    return _interpolated(episode.times[good], values[good], times, episode.arc[good])


def _interpolated(
    known: Floats, values: Floats, times: Floats, arc: np.ndarray | None = None
) -> tuple[Floats, Bools]:
    """Return values at ``times`` between neighbouring samples, and where that is allowed.

    Neighbours must be near in time and, where ``arc`` is given, on one unbroken arc.
    """
    right = np.clip(np.searchsorted(known, times - ROUNDING), 1, max(len(known) - 1, 1))
    if len(known) < 2:
        shape = (len(times), values.shape[1])
        return np.zeros(shape), np.zeros(shape, dtype=bool)
    left = right - 1
    gap = known[right] - known[left]
    share = ((times - known[left]) / gap)[:, None]
    value = (1 - share) * values[left] + share * values[right]
    # A time on a sample needs no neighbour, which may have no label.
    on_left, on_right = np.abs(share[:, 0]) < 1e-6, np.abs(share[:, 0] - 1) < 1e-6
    value[on_left], value[on_right] = values[left[on_left]], values[right[on_right]]
    between = (gap <= MAX_GAP) & (share[:, 0] > -1e-6) & (share[:, 0] < 1 + 1e-6)
    if arc is not None:
        between &= arc[left] == arc[right]
    mask = (between | on_left | on_right)[:, None] & np.isfinite(value)
    return np.where(mask, value, 0.0), mask
