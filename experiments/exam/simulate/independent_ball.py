"""The independent ball: an integrator of the independent laws, event by event.

Steps use Kutta's 3/8 rule; bounces are located by Newton's method on the step length. The table has
no edges to hit and no resting contact, and there is no net.
"""

from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import ArrayLike

from experiments.exam.simulate import laws
from experiments.exam.simulate.laws import Physics, bounce, derivative, normal_of
from rallygap.models.ball import state as ball
from rallygap.models.ball.contact_laws import NONE, TABLE
from rallygap.models.ball.simulator import Contacts, Flight
from rallygap.models.ball.state import BALL_RADIUS, TABLE_HALF_LENGTH, TABLE_HALF_WIDTH
from rallygap.models.ball.types import Floats, Integers
from rallygap.models.support.compilation import compiler

compiled = compiler([Path(__file__), Path(str(laws.__file__)), Path(str(ball.__file__))])

LONGEST_STEP = 0.0025  # s
MOST_BOUNCES = 8  # of a shot; further contacts are ignored


@dataclass(frozen=True)
class IndependentBall:
    """A ball that follows the independent laws."""

    physics: Physics

    def fly(self, states: ArrayLike, times: ArrayLike) -> Flight:
        """Roll out balls; arguments and result are those of ``Simulator.fly``."""
        first = np.array(np.atleast_2d(states), dtype=np.float64)
        moments = np.atleast_2d(np.asarray(times, dtype=np.float64))
        moments = np.ascontiguousarray(np.broadcast_to(moments, (len(first), moments.shape[1])))
        paths, count, time, before, after = _fly(first, moments, self.physics)
        surfaces = np.where(np.arange(MOST_BOUNCES) < count[:, None], TABLE, NONE)
        return Flight(paths, Contacts(count, time, surfaces, before, after))


@compiled
def _fly(
    first: Floats, moments: Floats, q: Physics
) -> tuple[Floats, Integers, Floats, Floats, Floats]:
    balls, length = moments.shape
    paths = np.empty((balls, length, 9))
    count = np.zeros(balls, dtype=np.int64)
    time = np.full((balls, MOST_BOUNCES), np.nan)
    before = np.full((balls, MOST_BOUNCES, 9), np.nan)
    after = np.full((balls, MOST_BOUNCES, 9), np.nan)
    for b in range(balls):
        y, now = first[b].copy(), 0.0
        for k in range(length):
            if moments[b, k] < now:
                span = moments[b, k] - now  # backwards, in free flight
                pieces = int(np.ceil(-span / LONGEST_STEP))
                paths[b, k] = y
                for _ in range(pieces):
                    paths[b, k] = step(paths[b, k], span / pieces, q)
                continue
            count[b] = _onwards(y, now, moments[b, k], q, count[b], time[b], before[b], after[b])
            now = moments[b, k]
            paths[b, k] = y
    return paths, count, time, before, after


@compiled
def _onwards(
    y: Floats,
    now: float,
    until: float,
    q: Physics,
    bounces: int,
    time: Floats,
    before: Floats,
    after: Floats,
) -> int:
    """Move a ball on to a later moment, in place; return its bounces so far."""
    left = until - now
    while left > 0.0:
        h = min(left, LONGEST_STEP)
        ahead = step(y, h, q)
        met = bounces < MOST_BOUNCES and _enters(ahead, q)
        if met:
            h, ahead = _touch(y, ahead, h, q)
        left -= h
        y[:] = ahead
        if met:
            time[bounces] = until - left
            before[bounces] = y
            bounce(y, q)
            after[bounces] = y
            bounces += 1
    return bounces


@compiled
def step(y: Floats, h: float, q: Physics) -> Floats:
    """Return the state (9,) after ``h`` seconds of free flight."""
    slopes, point = np.empty((4, 9)), np.empty(9)
    derivative(y, q, slopes[0])
    for i in range(9):
        point[i] = y[i] + h * slopes[0, i] / 3.0
    derivative(point, q, slopes[1])
    for i in range(9):
        point[i] = y[i] + h * (slopes[1, i] - slopes[0, i] / 3.0)
    derivative(point, q, slopes[2])
    for i in range(9):
        point[i] = y[i] + h * (slopes[0, i] - slopes[1, i] + slopes[2, i])
    derivative(point, q, slopes[3])
    for i in range(9):
        middle = 3.0 * (slopes[1, i] + slopes[2, i])
        point[i] = y[i] + h * (slopes[0, i] + middle + slopes[3, i]) / 8.0
    return point


@compiled
def _gap(y: Floats, q: Physics) -> tuple[float, float]:
    """Return how far a ball is from the table's plane (m) and how fast it leaves it (m/s)."""
    nx, ny, nz = normal_of(q)
    gap = nx * y[0] + ny * y[1] + nz * (y[2] - q.table_height_h) - BALL_RADIUS
    return gap, nx * y[3] + ny * y[4] + nz * y[5]


@compiled
def _enters(y: Floats, q: Physics) -> bool:
    if abs(y[0]) > TABLE_HALF_WIDTH or abs(y[1]) > TABLE_HALF_LENGTH:
        return False
    gap, leaving = _gap(y, q)
    return -BALL_RADIUS < gap < 0.0 and leaving < 0.0


@compiled
def _touch(y: Floats, ahead: Floats, h: float, q: Physics) -> tuple[float, Floats]:
    """Return when within a step a ball meets the table, and its state there (Newton)."""
    moment = h
    for _ in range(20):
        gap, leaving = _gap(ahead, q)
        shift = -gap / min(leaving, -1e-6)
        moment = min(max(moment + shift, 0.0), h)
        ahead = step(y, moment, q)
        if abs(shift) < 1e-14:
            break
    return moment, ahead
