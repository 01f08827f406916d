"""Trials of sim-to-real: policies play replayed balls, and balls that they are told wrongly of."""

from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import ClassVar, Protocol

import numpy as np
import pandas as pd
from numpy.typing import NDArray

from models.ball.simulator import Simulator
from models.policy.goals import Goals, draw_goals
from models.policy.incoming_balls import FIRST_WINDOW, Incoming
from models.policy.policy import Policy
from models.policy.settings import HorizonsMs
from models.predictors.physics import PhysicsPredictor
from models.predictors.protocol import Predictor
from models.replay.after_contact import struck
from models.replay.perturbed_forecasts import ERRORS
from models.replay.replayed_balls import Views, every_tick, first_window, predicted, views
from models.shot_quality.shots import landings
from pipeline.evaluation.predictors import ARENA, ORACLE, NamedPredictor, one_thread
from pipeline.io.amended_simulators import AMENDED
from pipeline.params import Sim2RealSettings
from pipeline.policies.storage import TrainedPolicy, load_policies
from pipeline.runtime.errors import InputError
from pipeline.transfer.replay_sets import ARENA_SETS, ReplaySet
from pipeline.transfer.returns import with_states
from pipeline.transfer.trials import try_policy

Floats = NDArray[np.float64]
Policies = Sequence[tuple[Policy, TrainedPolicy]]
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
    policies: Policies
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
        played = try_policy(policy, trained, shots.simulator, incoming, self.goals)
        back = played["returned"].to_numpy(dtype=np.bool_)
        after = struck(
            policy, shots.simulator, incoming[back], self.goals[back], trained.observation
        )
        return with_states(played, after, landings(shots.simulator, after)).assign(
            set=shots.name, predictor=forecaster.name, protocol=forecaster.protocol
        )


def players(folder: Path, settings: Sim2RealSettings) -> Policies:
    """Read the policies that measured balls are replayed to: of one group, from one simulator.

    Args:
        folder: of all trained policies.
        settings: name group and simulator.

    Raises:
        InputError: there is none, or a file is broken.
    """
    group = load_policies(folder, settings.group)
    policies = [one for one in group if one[1].simulator == settings.simulator]
    if not policies:
        problem = f"has no policy of {settings.group} that was trained in {settings.simulator}"
        raise InputError(folder, problem, field="sim2real.simulator")
    return policies


def replays(
    shots: ReplaySet, forecasters: Iterable[Forecaster], policies: Policies, seed: int
) -> list[ReplayTrial]:
    """Return the trials of a set, with the same goals whoever plays and forecasts.

    Args:
        shots: the set.
        forecasters: each of them tells all policies.
        policies: trained for the same goals.
        seed: of the goals.
    """
    random = np.random.default_rng([*stream(seed), *shots.name.encode()])
    goals = draw_goals(policies[0][1].goals, len(shots), random)
    seen = views(shots.shots)
    return [ReplayTrial(shots, seen, forecaster, policies, goals) for forecaster in forecasters]


def informed(
    shots: ReplaySet, learned: Iterable[NamedPredictor], amended: Simulator | None
) -> list[EveryTick]:
    """Return those who know more of a set's balls than the policies' own simulator does.

    These are what was learned, physics with the amended simulator, and the oracle, each where there
    is one.
    """
    told = [EveryTick(one.name, one.predictor) for one in learned]
    if amended is not None:
        told.append(EveryTick(AMENDED, PhysicsPredictor(amended)))
    if shots.oracle is not None:
        told.append(EveryTick(ORACLE, PhysicsPredictor(shots.oracle)))
    return told


def source_of(shots: ReplaySet) -> str:
    """Return the source of a set: the arena has several."""
    return ARENA if shots.name in ARENA_SETS else shots.name


def stream(seed: int) -> list[int]:
    """Return the seed of draws that no training makes."""
    return [seed, *b"sim2real"]


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
