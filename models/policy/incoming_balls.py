"""Incoming balls: their true paths, when they can be played, and what is forecast of them."""

import math
from collections.abc import Callable
from dataclasses import dataclass
from typing import TypeAlias

import numpy as np
from numpy.typing import ArrayLike, NDArray

from models.ball.contact_laws import TABLE
from models.ball.simulator import Flight, Simulator
from models.ball.state import BALL_RADIUS
from models.policy.goals import Goals

Floats = NDArray[np.float64]
Rows = slice | NDArray[np.bool_] | NDArray[np.integer]

PATH_STEP = 0.001  # s; a ball of 20 m/s moves its own radius
TICK = 0.040  # s between two decisions of the policy
LONGEST = 1.4  # s from the launch, by when a ball counts as gone
FURTHEST = 0.300  # s ahead that a predictor sees; paths are known that much longer
PATH_TIMES = PATH_STEP * np.arange(round((LONGEST + FURTHEST) / PATH_STEP) + 1)
FIRST_WINDOW = 0.055  # s from the launch until a predictor has seen its 12 measurements

FLOOR = -0.76 + BALL_RADIUS  # m, height of a ball on the floor (ITTF Law 2.1)
BEHIND = -2.40  # m along the table; the robot's racket gets no further back


@dataclass(frozen=True)
class Incoming:
    """B balls on their way to the robot.

    Attributes:
        path: (B, N, 9) true states ``PATH_STEP`` apart from the launch on, N = len(PATH_TIMES).
            Where a racket does not change it, the ball goes on as it would, through its second
            bounce and below the floor.
        playable: (B, 2) s from the launch: the bounce on the robot's half, and the moment when the
            ball is gone, ``LONGEST`` at most: its second bounce, the floor, or out of reach behind
            the robot. NaN twice where the ball cannot be played at all.
        start: s from the launch of the first control tick: 0, or ``FIRST_WINDOW`` where the
            predictor must have seen the ball before.
        forecasts: (B, T, H, 9) states that the predictor expects: at tick k, which is
            ``start + k * TICK`` after the launch, those at each of the H horizons after the tick.
            T = len(tick_times(start)): there is a tick at every moment before ``LONGEST``.
    """

    path: Floats
    playable: Floats
    start: float
    forecasts: Floats

    def __len__(self) -> int:
        return len(self.path)

    def __getitem__(self, rows: Rows) -> "Incoming":
        """Return some of the balls."""
        return Incoming(self.path[rows], self.playable[rows], self.start, self.forecasts[rows])


Balls: TypeAlias = Callable[[int, np.random.Generator], tuple[Incoming, Goals]]
"""Where an environment gets so many balls from, each with what its return is asked to do."""


def tick_times(start: float) -> Floats:
    """Return the (T,) control ticks before ``LONGEST``, s from the launch."""
    count = math.ceil((LONGEST - start) / TICK - 1e-9)
    return np.array([start + k * TICK for k in range(count)])


def fly_in(simulator: Simulator, launches: Floats) -> tuple[Floats, Floats]:
    """Return ``path`` and ``playable`` of an ``Incoming`` as a simulator flies (B, 9) launches."""
    flight = simulator.fly(launches, PATH_TIMES)
    return flight.states, playable(flight, PATH_TIMES)


def playable(flight: Flight, times: ArrayLike) -> Floats:
    """Return when balls can be played, to the nearest of the (T,) times at which they were flown.

    Returns:
        (B, 2) s as in ``Incoming``: NaN where the first contact is not the robot's half, or the
        ball is gone by then.
    """
    moments, contacts = np.asarray(times), flight.contacts
    bounce, second = contacts.time[:, 0], contacts.time[:, 1]
    lost = (flight.states[..., 1] < BEHIND) | (flight.states[..., 2] < FLOOR)
    passed = np.where(lost.any(axis=1), moments[lost.argmax(axis=1)], np.inf)
    gone = np.minimum(np.fmin(passed, second), LONGEST)
    near = (contacts.surface[:, 0] == TABLE) & (contacts.before[:, 0, 1] < 0) & (bounce < gone)
    return np.where(near[:, None], np.stack([bounce, gone], axis=1), np.nan)
