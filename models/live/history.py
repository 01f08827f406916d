"""The history of a track: its last measurements on the grid of times that predictors read."""

import numpy as np

from rallygap.models.ball.compose import compiled
from rallygap.models.ball.types import Bools, Floats
from rallygap.models.live.track import Track
from rallygap.models.predictors.protocol import HISTORY_TIMES, History

LONGEST_GAP = 3  # ticks between measurements, across which positions are interpolated
ROUNDING = 0.01  # ticks, by which two times may differ by rounding


def history_of(track: Track) -> History:
    """Return the history that ends at a track's last measurement.

    Positions are interpolated between the measurements on either side; those in longer gaps, and
    before the first measurement, count as not measured. A spin label belongs to the nearest time.

    Args:
        track: with one measurement or more.
    """
    states, mask = _on_grid(track.times, track.positions, track.spins, HISTORY_TIMES)
    return History(states, mask)


@compiled
def _on_grid(times: Floats, positions: Floats, spins: Floats, grid: Floats) -> tuple[Floats, Bools]:
    """Return (1, 12, 6) states, and where there are any, at times before the last measurement."""
    count, tick, last = len(grid), grid[-1] - grid[-2], times[-1]
    states, mask = np.zeros((1, count, 6)), np.zeros((1, count, 6), dtype=np.bool_)
    same, longest = ROUNDING * tick, LONGEST_GAP * tick
    for k in range(count):
        t = last + grid[k]
        after = np.searchsorted(times, t - same)
        if abs(times[after] - t) < same:
            states[0, k, :3], mask[0, k, :3] = positions[after], True
        elif after > 0 and times[after] - times[after - 1] <= longest:
            share = (t - times[after - 1]) / (times[after] - times[after - 1])
            states[0, k, :3] = (1 - share) * positions[after - 1] + share * positions[after]
            mask[0, k, :3] = True
    for n in range(len(times)):
        place = count - 1 + round((times[n] - last) / tick)
        if place >= 0 and np.isfinite(spins[n, 0]):
            states[0, place, 3:], mask[0, place, 3:] = spins[n], True
    return states, mask
