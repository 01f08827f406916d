"""The history of a track: its last measurements on the grid of times that predictors read."""

import numpy as np

from models.live.track import Track
from models.predictors.protocol import HISTORY, HISTORY_TIMES, TICK, History

LONGEST_GAP = 3 * TICK  # s between measurements, across which positions are interpolated
SAME = TICK / 100  # s, by which two times may differ by rounding


def history_of(track: Track) -> History:
    """Return the history that ends at a track's last measurement.

    Positions are interpolated between the measurements on either side; those in longer gaps, and
    before the first measurement, count as not measured. A spin label belongs to the nearest time.

    Args:
        track: with one measurement or more.
    """
    grid = track.last + HISTORY_TIMES
    times, labelled = track.times, np.isfinite(track.spins[:, 0])
    states, mask = np.zeros((HISTORY, 6)), np.zeros((HISTORY, 6), dtype=bool)
    if len(times) == 1:
        states[-1, :3], mask[-1, :3] = track.positions[0], True
    else:
        after = np.clip(np.searchsorted(times, grid - SAME), 1, len(times) - 1)
        gap = times[after] - times[after - 1]
        near = (gap <= LONGEST_GAP) | (np.abs(times[after] - grid) < SAME)
        known = near & (grid > times[0] - SAME)
        share = ((grid - times[after - 1]) / gap)[:, None]
        between = (1 - share) * track.positions[after - 1] + share * track.positions[after]
        states[known, :3], mask[known, :3] = between[known], True
    places = np.rint((times[labelled] - track.last) / TICK).astype(int) + HISTORY - 1
    recent = places >= 0
    states[places[recent], 3:] = track.spins[labelled][recent]
    mask[places[recent], 3:] = True
    return History(states[None], mask[None])
