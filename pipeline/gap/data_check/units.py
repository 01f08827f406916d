"""Units of time and position, from the frame interval and from how fast the ball falls."""

from collections.abc import Mapping, Sequence

import numpy as np

from rallygap.pipeline.gap.data_check.fall import Fall
from rallygap.pipeline.gap.data_check.problem import Problem, Setup
from rallygap.pipeline.gap.data_check.tracks import Track
from rallygap.pipeline.sources.conversion import POSITION_UNITS, TIME_UNITS

# s between two samples; beyond these limits no ball can be followed.
SHORTEST_STEP, LONGEST_STEP = 1e-5, 0.2
GRAVITY = 9.81  # m/s^2
# m/s^2 of a falling ball, with the lift of any spin; between units lies a factor of ten or more.
FALLS = (1.0, 60.0)
EXTENTS = (0.2, 15.0)  # m, largest extent of a typical recording


def time_scale(tracks: Sequence[Track]) -> float:
    """Return how many units of the tracks' times make a second: a power of a thousand."""
    step, scale = _step(tracks), 1.0
    while step / scale > LONGEST_STEP:
        scale *= 1000
    while step / scale < SHORTEST_STEP:
        scale /= 1000
    return scale


def length_scale(tracks: Sequence[Track], fall: Fall, setup: Setup) -> float:
    """Return how many units of the tracks' positions make a metre; 1 where no unit explains more.

    Args:
        tracks: with times in s.
        fall: of these tracks.
        setup: of the source.
    """
    if _within(fall.size, FALLS):
        return 1.0
    extent, present = _extent(tracks), POSITION_UNITS[setup.units.position]
    scales = np.array(list(POSITION_UNITS.values())) / present
    possible = [
        scale
        for scale in scales
        if _within(fall.size / scale, FALLS) and _within(extent / scale, EXTENTS)
    ]
    return min(possible, key=lambda scale: abs(np.log(fall.size / scale / GRAVITY)), default=1.0)


def unit_problem(
    tracks: Sequence[Track], second: float, metre: float, setup: Setup
) -> Problem | None:
    """Return what is wrong with the units, of which so many make a second and a metre."""
    units, changes, found = setup.units, {}, []
    if second != 1:
        changes["time"] = _unit(TIME_UNITS, TIME_UNITS[units.time] * second)
        found.append(f"t is not in {units.time}: samples would be {_step(tracks):.4g} s apart")
    if metre != 1:
        changes["position"] = _unit(POSITION_UNITS, POSITION_UNITS[units.position] * metre)
        extent = f"recordings would extend over {_extent(tracks):.4g} m"
        found.append(f"positions are not in {units.position}: {extent}")
    if not found:
        return None
    guesses = " and ".join(unit or "another unit" for unit in changes.values())
    line = setup.units_line(**changes) if all(changes.values()) else ""
    return Problem(f"{', and '.join(found)}; {guesses}?", line)


def fall_problem(fall: Fall) -> Problem | None:
    """Return what is wrong with a ball that falls too fast in any unit."""
    if fall.size <= FALLS[1]:
        return None
    return Problem(f"the ball falls with {fall.size:.3g} m/s^2: are t in s and positions in m?")


def _step(tracks: Sequence[Track]) -> float:
    """Return the median time between two samples."""
    return float(np.median(np.concatenate([np.diff(track.times) for track in tracks])))


def _extent(tracks: Sequence[Track]) -> float:
    """Return the largest extent of a typical track."""
    return float(np.median([np.ptp(track.positions, axis=0).max() for track in tracks]))


def _unit(units: Mapping[str, float], number: float) -> str:
    """Return the unit of which so many make an SI unit; empty if there is none."""
    return next((name for name, one in units.items() if abs(one / number - 1) < 1e-6), "")


def _within(value: float, limits: tuple[float, float]) -> bool:
    return limits[0] <= value <= limits[1]
