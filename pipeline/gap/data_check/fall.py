"""The fall: accelerations in short windows of raw samples, without any assumption about axes."""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from rallygap.models.ball.types import Floats
from rallygap.pipeline.gap.data_check.tracks import Track

WINDOW = 0.12  # s
FEWEST_SAMPLES = 6  # in a window
FEWEST_WINDOWS = 5
KINK = 1.5  # residual, in the median of all windows, above which the ball touched something
RESTING = 0.1  # of a fast ball's speed, below which it lies or is held
ROUNDS = 10  # of the robust fit
RIDGE = 1e-3  # keeps it finite where all balls fly the same way


@dataclass(frozen=True)
class Fall:
    """Accelerations of the ball, in units of the tracks.

    Attributes:
        acceleration: (3,) that all windows share, across the direction of flight, where drag does
            not act: gravity, and lift if all shots have the same spin.
        velocities: (n, 3) of the windows.
    """

    acceleration: Floats
    velocities: Floats

    @property
    def size(self) -> float:
        """Magnitude of the shared acceleration."""
        return float(np.linalg.norm(self.acceleration))


def fall_of(tracks: Sequence[Track]) -> Fall | None:
    """Return how the ball falls; ``None`` if there are too few samples."""
    windows = np.array([window for track in tracks for window in _windows(track)])
    if len(windows) < FEWEST_WINDOWS:
        return None
    windows = windows[_is_flight(windows)]
    velocities, accelerations = windows[:, :3], windows[:, 3:6]
    return Fall(_shared_across(velocities, accelerations), velocities)


def _is_flight(windows: Floats) -> NDArray[np.bool_]:
    """Return which windows have a ball that moves and touches nothing."""
    speeds, residuals = np.linalg.norm(windows[:, :3], axis=1), windows[:, 6]
    moves = speeds > RESTING * np.quantile(speeds, 0.9)
    return np.asarray(moves & (residuals <= KINK * np.median(residuals[moves])))


def parabola(times: Floats, positions: Floats) -> tuple[Floats, Floats, float]:
    """Return velocity (3,) and acceleration (3,) at the middle time, and the RMS residual."""
    since = times - times.mean()
    terms = np.vander(since, 3)
    coefficients = np.linalg.lstsq(terms, positions)[0]
    residuals = positions - terms @ coefficients
    return coefficients[1], 2 * coefficients[0], float(np.sqrt((residuals**2).mean()))


def _windows(track: Track) -> Iterator[Floats]:
    """Yield velocity, acceleration and residual (7,) of windows that do not overlap."""
    numbers = ((track.times - track.times[0]) / WINDOW).astype(np.int64)
    starts = np.flatnonzero(np.diff(numbers, prepend=-1))
    for rows in np.split(np.arange(len(numbers)), starts[1:]):
        times = track.times[rows]
        if len(rows) >= FEWEST_SAMPLES and times[-1] - times[0] > WINDOW / 2:
            velocity, acceleration, residual = parabola(times, track.positions[rows])
            yield np.array([*velocity, *acceleration, residual])


def _shared_across(velocities: Floats, accelerations: Floats) -> Floats:
    """Return the acceleration (3,) that best explains all components across the velocities.

    Iteratively reweighted least squares with the L1 norm, because some windows have contacts.
    """
    speeds = np.maximum(np.linalg.norm(velocities, axis=1), 1e-12)
    along = velocities / speeds[:, None]
    across = np.eye(3) - along[:, :, None] * along[:, None, :]
    seen = np.einsum("nij,nj->ni", across, accelerations)
    shared, scale = np.median(accelerations, axis=0), np.median(np.linalg.norm(seen, axis=1))
    for _ in range(ROUNDS):
        misses = np.linalg.norm(seen - across @ shared, axis=1)
        weights = 1 / np.maximum(misses, 1e-3 * scale + 1e-12)
        information = np.einsum("n,nij->ij", weights, across) + RIDGE * weights.sum() * np.eye(3)
        shared = np.linalg.solve(information, weights @ seen)
    return np.asarray(shared)
