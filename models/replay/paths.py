"""The path of a ball: the arena's true one, and one estimated from measurements.

An estimate is, between contacts, the segmentation's Rauch-Tung-Striebel smoother, with a cubic
through the positions and velocities at the samples. Arcs that meet at the table are extrapolated to
the bounce.

The spin of an arc is the mean of its labels. Without labels the first arc has no spin, and a bounce
changes the spin by its impulse: angular momentum about the contact point is conserved.
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.interpolate import CubicHermiteSpline

from rallygap.models.arena.recording import TrueContacts
from rallygap.models.arena.truth import Truth
from rallygap.models.arena.truth_path import true_states
from rallygap.models.ball.state import BALL_RADIUS, STATE_SIZE
from rallygap.models.ball.types import Floats, Integers
from rallygap.models.policy.incoming_balls import PATH_TIMES
from rallygap.models.predictors.ball_filter import POSITION_NOISE
from rallygap.models.predictors.windows import Episode
from rallygap.models.segmentation.contacts import extrapolated
from rallygap.models.segmentation.flight import smooth

STROKES = ("launch", "racket")
FEWEST_SAMPLES = 3  # needed to estimate an arc's velocity


@dataclass(frozen=True)
class _Arc:
    """An arc from ``begin`` to ``end`` (s), with its spin."""

    begin: float
    end: float
    path: CubicHermiteSpline
    spin: Floats

    def states(self, times: NDArray[np.floating]) -> Floats:
        """Return (T, 9) states."""
        spins = np.broadcast_to(self.spin, (len(times), 3))
        return np.hstack([self.path(times), self.path(times, 1), spins])


def measured_path(measured: Episode) -> tuple[Floats, Floats]:
    """Return the path of a ball up to its last sample, or to a contact with anything but the table.

    Args:
        measured: its samples, the first of them at time zero.

    Returns:
        (n, 9) states at the first n of ``PATH_TIMES``, and (C,) s of the bounces before; both empty
        where the first arc has too few samples.
    """
    arcs = _arcs(measured)
    states = [np.empty((0, STATE_SIZE))]
    for arc in arcs:
        first, last = np.searchsorted(PATH_TIMES, [arc.begin, arc.end])
        states.append(arc.states(PATH_TIMES[first:last]))
    return np.concatenate(states), np.array([arc.begin for arc in arcs[1:]])


def _arcs(measured: Episode) -> list[_Arc]:
    """Return the arcs up to the first that does not end at a bounce."""
    arcs: list[_Arc] = []
    begin = 0.0
    borders = np.flatnonzero(np.diff(measured.arc)) + 1
    for rows in np.split(np.arange(len(measured.times)), borders):
        if (~measured.outlier[rows]).sum() < FEWEST_SAMPLES:
            break
        bounce = _bounce_after(measured, rows[-1])
        end = measured.times[rows[-1]] if bounce is None else bounce
        arcs.append(_arc(measured, rows, begin, end, arcs[-1] if arcs else None))
        if bounce is None:
            break
        begin = bounce
    return arcs


def _bounce_after(measured: Episode, sample: int) -> float | None:
    """Return the time of a bounce between a sample and the next, if there is one."""
    around = measured.times[sample : sample + 2]
    bounce = measured.bounces[np.searchsorted(measured.bounces, around[0]) :][:1]
    there = len(around) == 2 and len(bounce) and bounce[0] <= around[1]
    return float(bounce[0]) if there else None


def _arc(measured: Episode, rows: Integers, begin: float, end: float, before: _Arc | None) -> _Arc:
    used = rows[~measured.outlier[rows]]
    span = slice(used[0], used[-1] + 1)
    times, good = measured.times[span], ~measured.outlier[span]
    means = smooth(times, np.ascontiguousarray(measured.positions[span]), good, POSITION_NOISE)
    if begin < times[0]:
        means = np.stack([extrapolated(means[0], begin - times[0]), *means])
        times = np.r_[begin, times]
    if end > times[-1]:
        means = np.stack([*means, extrapolated(means[-1], end - times[-1])])
        times = np.r_[times, end]
    path = CubicHermiteSpline(times, means[:, 0], means[:, 1])
    return _Arc(begin, end, path, _spin(measured.spins[rows], path, before))


def _spin(labels: Floats, path: CubicHermiteSpline, before: _Arc | None) -> Floats:
    labelled = np.isfinite(labels).all(axis=1)
    if labelled.any():
        return labels[labelled].mean(axis=0)
    if before is None:
        return np.zeros(3)
    change = path(before.end, 1) - before.path(before.end, 1)
    # I = 2/3 m r^2, and the impulse acts a radius below the centre.
    spin_change: Floats = 3 / (2 * BALL_RADIUS) * np.array([change[1], -change[0], 0.0])
    return before.spin + spin_change


def true_path(truth: Truth, contacts: TrueContacts, start: float) -> tuple[Floats, Floats]:
    """Return the true path of a ball from ``start`` (s) to the next stroke or the end of the data.

    Args:
        truth: the arena's physics.
        contacts: of the recording; the ball's own stroke is the one nearest to ``start``.
        start: s, on the recording's clock.

    Returns:
        (n, 9) states at ``start`` plus the first n of ``PATH_TIMES``, and (C,) s from ``start`` of
        the bounces in that time.
    """
    strokes = contacts.times[np.isin(contacts.kinds, STROKES)]
    nearest = np.abs(strokes - start).argmin()
    struck = np.append(strokes, np.inf)[nearest + 1]
    times = np.asarray(start + PATH_TIMES, dtype=np.float64)
    states = true_states(truth, contacts, times)
    known = np.isfinite(states[:, 0]) & (times < struck)
    count = int(np.argmin(np.append(known, False)))
    bounces = contacts.times[contacts.kinds == "table"] - start
    return states[:count], bounces[(bounces > 0) & (bounces < PATH_TIMES[:count].max(initial=0))]
