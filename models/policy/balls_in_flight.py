"""Balls in flight: one per environment, each at its own control step."""

import numpy as np

from rallygap.models.ball.types import Bools, Floats, Integers
from rallygap.models.policy.incoming_balls import CONTROL_STEP, PATH_STEP, IncomingBalls

PATH_STEPS_PER_CONTROL = round(CONTROL_STEP / PATH_STEP)


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
