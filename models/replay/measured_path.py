"""The true path of a ball of which there are measurements alone: the smoothest one through them.

Between two contacts the ball is where the Rauch-Tung-Striebel smoother of the segmentation sees it,
with a cubic through the positions and velocities at the samples. Where two arcs meet at the table,
each is carried on to the bounce.

The spin of an arc is the mean of its labels. Where it has none, the ball starts without spin, and
the bounce changes it: the blow that changed the velocity acted at the ball's contact point, and the
angular momentum about that point stays.
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.interpolate import CubicHermiteSpline

from models.ball.state import BALL_RADIUS, STATE_SIZE
from models.policy.incoming_balls import PATH_TIMES
from models.predictors.physics import POSITION_NOISE
from models.predictors.windows import Episode
from models.segmentation.contacts import moved
from models.segmentation.smoothing import smooth

Floats = NDArray[np.float64]
Indices = NDArray[np.int64]

FEWEST_SAMPLES = 3  # from which an arc's velocity can be told


@dataclass(frozen=True)
class _Arc:
    """An arc from its beginning to its end, with its spin."""

    begin: float
    end: float
    path: CubicHermiteSpline
    spin: Floats

    def states(self, times: NDArray[np.floating]) -> Floats:
        """Return (T, 9) states."""
        spins = np.broadcast_to(self.spin, (len(times), 3))
        return np.hstack([self.path(times), self.path(times, 1), spins])


def measured_path(measured: Episode) -> tuple[Floats, Floats]:
    """Return where a ball was, as far as its measurements tell.

    That is until the last of them, or until something else than the table met it.

    Args:
        measured: its samples, the first of them at time zero.

    Returns:
        (n, 9) states at the first n of ``PATH_TIMES``, and (C,) s of the bounces before; both empty
        where the first samples tell of no path.
    """
    arcs = _arcs(measured)
    parts = [np.empty((0, STATE_SIZE))]
    for arc in arcs:
        first, last = np.searchsorted(PATH_TIMES, [arc.begin, arc.end])
        parts.append(arc.states(PATH_TIMES[first:last]))
    return np.concatenate(parts), np.array([arc.begin for arc in arcs[1:]])


def _arcs(measured: Episode) -> list[_Arc]:
    """Return the arcs up to the first that does not end at the table."""
    arcs: list[_Arc] = []
    begin = 0.0
    borders = np.flatnonzero(np.diff(measured.arc)) + 1
    for own in np.split(np.arange(len(measured.times)), borders):
        if (~measured.outlier[own]).sum() < FEWEST_SAMPLES:
            break
        bounce = _bounce_after(measured, own[-1])
        end = measured.times[own[-1]] if bounce is None else bounce
        arcs.append(_arc(measured, own, begin, end, arcs[-1] if arcs else None))
        if bounce is None:
            break
        begin = bounce
    return arcs


def _bounce_after(measured: Episode, sample: int) -> float | None:
    """Return when the ball met the table between a sample and the next, if it did."""
    around = measured.times[sample : sample + 2]
    met = measured.bounces[np.searchsorted(measured.bounces, around[0]) :][:1]
    return float(met[0]) if len(around) == 2 and len(met) and met[0] <= around[1] else None


def _arc(measured: Episode, own: Indices, begin: float, end: float, before: _Arc | None) -> _Arc:
    used = own[~measured.outlier[own]]
    rows = slice(used[0], used[-1] + 1)
    times, good = measured.times[rows], ~measured.outlier[rows]
    means = smooth(times, np.ascontiguousarray(measured.positions[rows]), good, POSITION_NOISE)
    if begin < times[0]:
        times, means = np.r_[begin, times], np.stack([moved(means[0], begin - times[0]), *means])
    if end > times[-1]:
        times, means = np.r_[times, end], np.stack([*means, moved(means[-1], end - times[-1])])
    path = CubicHermiteSpline(times, means[:, 0], means[:, 1])
    return _Arc(begin, end, path, _spin(measured.spins[own], path, before))


def _spin(labels: Floats, path: CubicHermiteSpline, before: _Arc | None) -> Floats:
    labelled = np.isfinite(labels).all(axis=1)
    if labelled.any():
        mean: Floats = labels[labelled].mean(axis=0)
        return mean
    if before is None:
        return np.zeros(3)
    change = path(before.end, 1) - before.path(before.end, 1)
    # I = 2/3 m r^2, and the blow acts a radius below the centre.
    blow: Floats = 3 / (2 * BALL_RADIUS) * np.array([change[1], -change[0], 0.0])
    return before.spin + blow
