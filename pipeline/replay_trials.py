"""Trials of sim-to-real: policies play replayed balls, and balls that they are told wrongly of."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import partial
from typing import ClassVar, Protocol

import numpy as np
import pandas as pd
from numpy.typing import NDArray

from models.ball.simulator import Simulator
from models.policy.goals import Goals
from models.policy.incoming import FIRST_WINDOW, Incoming
from models.policy.policy import Policy
from models.policy.replay import Views, every_tick, first_window, predicted
from models.policy.settings import HorizonsMs
from models.policy.tolerance import ERRORS
from models.predictors.protocol import Predictor
from pipeline.policies import TrainedPolicy
from pipeline.predictors import one_thread
from pipeline.replays import ReplaySet
from pipeline.trials import try_policy

Floats = NDArray[np.float64]
Told = Callable[[HorizonsMs], Floats]
"""The forecasts of some balls, at the horizons that a policy wants."""


class Forecaster(Protocol):
    """Who tells policies of the ball, from what was measured of it."""

    protocol: ClassVar[str]

    @property
    def name(self) -> str:
        """Of the predictor."""
        ...

    def told(self, views: Views) -> Told:
        """Forecast the balls of ``views``."""
        ...


@dataclass(frozen=True)
class EveryTick:
    """A predictor that is asked anew at every control tick."""

    name: str
    predictor: Predictor
    protocol: ClassVar[str] = "every_tick"

    def told(self, views: Views) -> Told:
        """Forecast from every history."""
        return partial(every_tick, predicted(self.predictor, views.history), views)


@dataclass(frozen=True)
class FirstWindow:
    """A filter over the first measurements, and a simulator for the whole flight from there."""

    name: str
    simulator: Simulator
    protocol: ClassVar[str] = "first_window"

    def told(self, views: Views) -> Told:
        """Forecast from the first history."""
        return partial(first_window, self.simulator, views)


@dataclass(frozen=True)
class ReplayTrial:
    """All policies play the shots of a set, told of them by one forecaster."""

    shots: ReplaySet
    views: Views
    forecaster: Forecaster
    policies: Sequence[tuple[Policy, TrainedPolicy]]
    goals: Goals

    def results(self) -> pd.DataFrame:
        """Return how each shot ended with each policy, and how far the forecasts were off."""
        with one_thread():
            told = self.forecaster.told(self.views)
        parts = [self._played(policy, trained, told) for policy, trained in self.policies]
        return pd.concat(parts, ignore_index=True)

    def _played(self, policy: Policy, trained: TrainedPolicy, told: Told) -> pd.DataFrame:
        shots, forecaster = self.shots, self.forecaster
        incoming = Incoming(shots.path, shots.playable, FIRST_WINDOW, told(trained.horizons))
        return try_policy(policy, trained, shots.simulator, incoming, self.goals).assign(
            set=shots.name, predictor=forecaster.name, protocol=forecaster.protocol
        )


@dataclass(frozen=True)
class ToleranceTrial:
    """A policy plays balls of its own simulator, told of them with an error.

    Every trial of a policy has the same balls, and errors of all sizes the same directions.

    Attributes:
        policy: plays.
        trained: what for.
        error: which of ``ERRORS``.
        size: of the error, m.
        balls: how many.
        stream: where balls, goals and errors come from.
    """

    policy: Policy
    trained: TrainedPolicy
    error: str
    size: float
    balls: int
    stream: Sequence[int]

    def results(self) -> pd.DataFrame:
        """Return how each ball ended."""
        task, random = self.trained.task, np.random.default_rng(self.stream)
        balls, goals = task.practice(self.balls, random)
        wrong = ERRORS[self.error](balls.forecasts, self.size, random)
        incoming = Incoming(balls.path, balls.playable, balls.start, wrong)
        return try_policy(self.policy, self.trained, task.simulator, incoming, goals).assign(
            error=self.error, size_cm=100 * self.size
        )
