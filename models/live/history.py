"""The history of a track: its last measurements on the grid of times that predictors read."""

import numpy as np

from models.ball.compose import compiled
from models.ball.types import Bools, Floats
from models.live.track import Track
from models.predictors.protocol import HISTORY, TICK, History

LONGEST_GAP = 3 * TICK  # s between measurements, across which positions are interpolated
SAME = TICK / 100  # s, by which two times may differ by rounding


def history_of(track: Track) -> History:
    """Return the history that ends at a track's last measurement.

    Positions are interpolated between the measurements on either side; those in longer gaps, and
    before the first measurement, count as not measured. A spin label belongs to the nearest time.

    Args:
        track: with one measurement or more.
    """
    states, mask = _on_grid(track.times, track.positions, track.spins)
    return History(states, mask)


@compiled
def _on_grid(times: Floats, positions: Floats, spins: Floats) -> tuple[Floats, Bools]:
    """Return (1, 12, 6) states, and where there are any, on the grid that ends at the last time."""
    states, mask = np.zeros((1, HISTORY, 6)), np.zeros((1, HISTORY, 6), dtype=np.bool_)
    last = times[-1]
    for k in range(HISTORY):
        t = last - (HISTORY - 1 - k) * TICK
        after = np.searchsorted(times, t - SAME)
        if abs(times[after] - t) < SAME:
            states[0, k, :3], mask[0, k, :3] = positions[after], True
        elif after > 0 and times[after] - times[after - 1] <= LONGEST_GAP:
            share = (t - times[after - 1]) / (times[after] - times[after - 1])
            states[0, k, :3] = (1 - share) * positions[after - 1] + share * positions[after]
            mask[0, k, :3] = True
    for n in range(len(times)):
        place = HISTORY - 1 + round((times[n] - last) / TICK)
        if place >= 0 and np.isfinite(spins[n, 0]):
            states[0, place, 3:], mask[0, place, 3:] = spins[n], True
    return states, mask
