"""What is unusual about recordings without being wrong."""

from collections.abc import Iterator, Sequence

import numpy as np

from rallygap.models.ball.types import Floats
from rallygap.pipeline.gap.data_check.axes import mostly_across
from rallygap.pipeline.gap.data_check.bounces import share_on_table
from rallygap.pipeline.gap.data_check.fall import Fall
from rallygap.pipeline.gap.data_check.flights import Flights
from rallygap.pipeline.gap.data_check.heights import height_doubts
from rallygap.pipeline.gap.data_check.spins import spin_doubts
from rallygap.pipeline.gap.data_check.tracks import Track
from rallygap.pipeline.gap.data_check.units import GRAVITY

TILT = 30.0  # degrees between gravity and -z; less may be lift
FALLS = (6.0, 15.0)  # m/s^2 beyond which lift is an unlikely explanation
ROUNDED = 1e-3  # s
ROUNDING_ERROR = 1e-6  # s, of a time stamp that is a multiple of ROUNDED
FEWEST_BOUNCES = 5
SAME_SPEED = 0.05  # relative standard deviation of the speeds of recordings


def doubts_of(
    tracks: Sequence[Track], fall: Fall | None, flights: Flights, places: Floats
) -> Iterator[str]:
    """Yield what is doubtful, one sentence each.

    Args:
        tracks: all of them.
        fall: of the tracks; ``None`` where they are too short.
        flights: of the tracks.
        places: (n, 3) of bounces, m.
    """
    if fall is not None:
        yield from _doubtful_fall(fall)
    yield from height_doubts(places)
    yield from spin_doubts(flights)
    if len(places) >= FEWEST_BOUNCES and share_on_table(places) < 0.5:
        x, y = np.median(places[:, :2], axis=0)
        yield (
            f"most bounces are outside the table, typically at x = {x:.2f} m and y = {y:.2f} m: "
            "check that the origin is at the table's centre"
        )
    if all(_is_rounded(track.times) for track in tracks):
        yield "time stamps are rounded to 1 ms: fast balls move by several millimetres in that time"
    speeds = np.array([_speed(track) for track in tracks])
    if len(speeds) >= FEWEST_BOUNCES and speeds.std() < SAME_SPEED * speeds.mean():
        yield (
            f"all shots have about the same speed, {speeds.mean():.1f} m/s: effects that depend on "
            "speed are not identifiable; record several speeds"
        )


def _doubtful_fall(fall: Fall) -> Iterator[str]:
    if mostly_across(fall.velocities):
        yield "balls fly along x, across the table: check that y is along it"
    tilt = np.degrees(np.arccos(np.clip(-fall.acceleration[2] / fall.size, -1.0, 1.0)))
    if tilt > TILT:
        yield f"gravity and mean lift point {tilt:.0f} degrees off -z: check the axes"
    if not FALLS[0] <= fall.size <= FALLS[1]:
        yield (
            f"the ball falls with {fall.size:.1f} m/s^2 instead of {GRAVITY}, lift included: check "
            "the units"
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
