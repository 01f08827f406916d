"""Deliveries: the balls on their way to many arms, each at its own time."""

import numpy as np
from numpy.typing import NDArray

from models.policy.incoming_balls import PATH_STEP, TICK, Incoming

Floats = NDArray[np.float64]
Booleans = NDArray[np.bool_]
Integers = NDArray[np.int64]

TICK_STEPS = round(TICK / PATH_STEP)  # path steps in a tick


class Deliveries:
    """One ball for each of B arms, and the tick at which it is.

    Attributes:
        bounce: (B,) path steps from the launch to the bounce on the robot's half; infinite for a
            ball that cannot be played.
        gone: (B,) path steps after which the ball is gone; zero for a ball that cannot be played.
    """

    bounce: Floats
    gone: Floats

    def __init__(self, incoming: Incoming) -> None:
        count = len(incoming)
        self._rows = np.arange(count)
        self._path, self._forecasts = (
            np.empty_like(incoming.path),
            np.empty_like(incoming.forecasts),
        )
        self._start, self._tick = np.zeros(count, dtype=np.int64), np.zeros(count, dtype=np.int64)
        self.bounce, self.gone = np.empty(count), np.empty(count)
        self.replace(np.ones(count, dtype=np.bool_), incoming)

    def replace(self, which: Booleans, incoming: Incoming) -> None:
        """Give the arms of ``which`` (B,) new balls, as many, with paths and forecasts as long."""
        self._path[which], self._forecasts[which] = incoming.path, incoming.forecasts
        self._start[which], self._tick[which] = round(incoming.start / PATH_STEP), 0
        bounce, gone = (incoming.playable / PATH_STEP).T
        self.bounce[which] = np.where(np.isnan(bounce), np.inf, bounce)
        self.gone[which] = np.nan_to_num(gone, nan=0.0)

    @property
    def first(self) -> Integers:
        """(B,) path steps from the launch to the beginning of the tick."""
        return self._start + TICK_STEPS * self._tick

    @property
    def forecasts(self) -> Floats:
        """(B, H, 9) states that the predictor expects now."""
        last = self._forecasts.shape[1] - 1
        expected: Floats = self._forecasts[self._rows, np.minimum(self._tick, last)]
        return expected

    def ahead(self) -> tuple[Integers, Floats]:
        """Return moments (S + 1, B), in path steps from the launch, and true states (S + 1, B, 9).

        They are those of the tick that begins, both its ends included.
        """
        moments = self.first + np.arange(TICK_STEPS + 1)[:, None]
        known = np.minimum(moments, self._path.shape[1] - 1)
        return moments, self._path[self._rows, known]

    def advance(self) -> None:
        """Go on to the next tick."""
        self._tick += 1
