"""Incoming balls: their true paths, when they can be played, and what is forecast of them.

``BallsInFlight`` are those that environments play, each at its own control step.
"""

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from rallygap.models.ball.contact_laws import TABLE
from rallygap.models.ball.simulator import Flight, Simulator
from rallygap.models.ball.state import BALL_RADIUS
from rallygap.models.ball.types import Bools, Floats, Integers

Rows = slice | NDArray[np.bool_] | NDArray[np.integer]

PATH_STEP = 0.001  # s; a ball of 20 m/s moves its own radius
CONTROL_STEP = 0.040  # s between two actions of the policy
PATH_STEPS_PER_CONTROL = round(CONTROL_STEP / PATH_STEP)
MAX_DURATION = 1.4  # s from the launch, after which a ball is out of play
MAX_HORIZON = 0.300  # s ahead that predictors forecast; paths extend that much longer
PATH_TIMES = PATH_STEP * np.arange(round((MAX_DURATION + MAX_HORIZON) / PATH_STEP) + 1)
FIRST_WINDOW = 0.055  # s from the launch, by when a predictor has its 12 measurements

FLOOR = -0.76 + BALL_RADIUS  # m, height of a ball on the floor (ITTF Law 2.1)
REACH_LIMIT = -2.40  # m, y; the racket reaches no further back


@dataclass(frozen=True)
class IncomingBalls:
    """B balls on their way to the robot.

    Attributes:
        path: (B, N, 9) true states without a racket, ``PATH_STEP`` apart from the launch on,
            N = len(PATH_TIMES); they continue past the second bounce and below the floor.
        playable: (B, 2) s from the launch: the bounce on the robot's half, and when the ball is out
            of play: at its second bounce, on the floor, behind the robot's reach, or after
            ``MAX_DURATION``. NaN where the ball cannot be played at all.
        start: s from the launch to the first control step: 0, or ``FIRST_WINDOW`` where the
            predictor needs measurements first.
        forecasts: (B, T, H, 9) states that the predictor forecasts at each of the T control steps
            of ``control_times(start)``, at the H horizons after it.
        spreads: (B, T, H, 3) m, standard deviations of the forecast positions; None where the
            predictor does not say them.
    """

    path: Floats
    playable: Floats
    start: float
    forecasts: Floats
    spreads: Floats | None = None

    def __len__(self) -> int:
        return len(self.path)

    def __getitem__(self, rows: Rows) -> "IncomingBalls":
        """Return some of the balls."""
        spreads = None if self.spreads is None else self.spreads[rows]
        return IncomingBalls(
            self.path[rows], self.playable[rows], self.start, self.forecasts[rows], spreads
        )


def control_times(start: float) -> Floats:
    """Return the (T,) times of control steps before ``MAX_DURATION``, s from the launch."""
    count = math.ceil((MAX_DURATION - start) / CONTROL_STEP - 1e-9)
    return np.array([start + k * CONTROL_STEP for k in range(count)])


def fly_incoming(simulator: Simulator, launches: Floats) -> tuple[Floats, Floats]:
    """Return ``path`` and ``playable`` of ``IncomingBalls`` for (B, 9) launches."""
    flight = simulator.fly(launches, PATH_TIMES)
    return flight.states, playable(flight, PATH_TIMES)


def playable(flight: Flight, times: ArrayLike) -> Floats:
    """Return when balls can be played, to the nearest of the (T,) times at which they were flown.

    Returns:
        (B, 2) s as in ``IncomingBalls``; NaN where the first contact is not on the robot's half, or
        the ball is out of play by then.
    """
    moments, contacts = np.asarray(times), flight.contacts
    bounce, second = contacts.time[:, 0], contacts.time[:, 1]
    lost = (flight.states[..., 1] < REACH_LIMIT) | (flight.states[..., 2] < FLOOR)
    passed = np.where(lost.any(axis=1), moments[lost.argmax(axis=1)], np.inf)
    gone = np.minimum(np.fmin(passed, second), MAX_DURATION)
    near = (contacts.surface[:, 0] == TABLE) & (contacts.before[:, 0, 1] < 0) & (bounce < gone)
    return np.where(near[:, None], np.stack([bounce, gone], axis=1), np.nan)


class BallsInFlight:
    """The balls of B environments.

    Attributes:
        bounce: (B,) path steps from the launch to the bounce on the robot's half; infinite for a
            ball that cannot be played.
        gone: (B,) path steps after which the ball is out of play; zero for a ball that cannot be
            played.
    """

    bounce: Floats
    gone: Floats

    def __init__(self, incoming: IncomingBalls) -> None:
        count = len(incoming)
        self._rows = np.arange(count)
        self._path = np.empty_like(incoming.path)
        self._forecasts = np.empty_like(incoming.forecasts)
        self._spreads = None if incoming.spreads is None else np.empty_like(incoming.spreads)
        self._start, self._step = np.zeros(count, dtype=np.int64), np.zeros(count, dtype=np.int64)
        self.bounce, self.gone = np.empty(count), np.empty(count)
        self.replace(np.ones(count, dtype=np.bool_), incoming)

    def replace(self, which: Bools, incoming: IncomingBalls) -> None:
        """Give the environments of ``which`` (B,) new balls, with paths and forecasts as long."""
        self._path[which], self._forecasts[which] = incoming.path, incoming.forecasts
        if self._spreads is not None:
            self._spreads[which] = incoming.spreads
        self._start[which], self._step[which] = round(incoming.start / PATH_STEP), 0
        bounce, gone = (incoming.playable / PATH_STEP).T
        self.bounce[which] = np.where(np.isnan(bounce), np.inf, bounce)
        self.gone[which] = np.nan_to_num(gone, nan=0.0)

    @property
    def first(self) -> Integers:
        """(B,) path steps from the launch to the beginning of the control step."""
        return self._start + PATH_STEPS_PER_CONTROL * self._step

    @property
    def forecasts(self) -> Floats:
        """(B, H, 9) states that the predictor forecasts now."""
        return self._now(self._forecasts)

    @property
    def spreads(self) -> Floats | None:
        """(B, H, 3) standard deviations of their positions, where the predictor says them."""
        return None if self._spreads is None else self._now(self._spreads)

    def ahead(self) -> tuple[Integers, Floats]:
        """Return moments (S + 1, B), in path steps from the launch, and true states (S + 1, B, 9).

        They span the coming control step, both its ends included.
        """
        moments = self.first + np.arange(PATH_STEPS_PER_CONTROL + 1)[:, None]
        known = np.minimum(moments, self._path.shape[1] - 1)
        return moments, self._path[self._rows, known]

    def advance(self) -> None:
        """Go on to the next control step."""
        self._step += 1

    def _now(self, values: Floats) -> Floats:
        """Return those of (B, T, ...) values that belong to the control step of each ball."""
        return values[self._rows, np.minimum(self._step, values.shape[1] - 1)]
