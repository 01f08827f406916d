"""Trials of sim-to-real: policies play replayed shots with forecasts from measurements."""

from collections.abc import Callable, Collection, Iterable, Sequence
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import cast

import numpy as np
import pandas as pd

from rallygap.models.ball.simulator import Simulator
from rallygap.models.ball.types import Floats
from rallygap.models.policy.goals import Goals, draw_goals
from rallygap.models.policy.incoming_balls import FIRST_WINDOW, IncomingBalls
from rallygap.models.policy.policy import Policy
from rallygap.models.policy.settings import HorizonsMs
from rallygap.models.predictors.physics import PhysicsPredictor
from rallygap.models.predictors.protocol import Predictor, ProbabilisticPredictor
from rallygap.models.replay.replayed_balls import (
    Histories,
    anchored,
    every_step,
    measurement_histories,
    perturbed,
    predict_all,
    predict_all_with_spreads,
)
from rallygap.pipeline.evaluation.predictors import ARENA, ORACLE, NamedPredictor
from rallygap.pipeline.io.amended_simulators import AMENDED
from rallygap.pipeline.params import Sim2RealSettings
from rallygap.pipeline.policies.storage import TrainedPolicy, load_policies
from rallygap.pipeline.runtime.errors import InputError
from rallygap.pipeline.runtime.stage_run import StageRun
from rallygap.pipeline.runtime.torch_threads import one_thread
from rallygap.pipeline.transfer.replay_sets import ARENA_SETS, ReplaySet
from rallygap.pipeline.transfer.returns import EVERY_STEP, with_states
from rallygap.pipeline.transfer.trials import Played, play_policy

Policies = Sequence[tuple[Policy, TrainedPolicy]]
Forecasts = Callable[[HorizonsMs], tuple[Floats, Floats | None]]
"""Forecasts of some shots at the horizons of a policy, and their spreads, as ``IncomingBalls`` has
them."""


@dataclass(frozen=True)
class Forecaster:
    """Forecasts replayed shots for policies, from their measurements.

    Attributes:
        name: of the predictor.
        predictor: forecasts.
        mode: when it does: ``EVERY_STEP`` or ``ONCE``, or the number of control steps from one
            forecast to the next; ``protocol`` in tables.
        spreads: whether it also says how sure it is; with ``EVERY_STEP`` alone.
    """

    name: str
    predictor: Predictor
    mode: str | int = EVERY_STEP
    spreads: bool = False

    def forecasts(self, histories: Histories) -> Forecasts:
        """Forecast shots from their measurement histories."""
        if self.mode != EVERY_STEP:
            every = self.mode if isinstance(self.mode, int) else None
            return lambda horizons: (anchored(self.predictor, histories, horizons, every), None)
        if self.spreads:
            predictor = cast(ProbabilisticPredictor, self.predictor)
            means, spreads = predict_all_with_spreads(predictor, histories.history)
            return lambda horizons: (
                every_step(means, histories, horizons),
                every_step(spreads, histories, horizons),
            )
        states = predict_all(self.predictor, histories.history)
        return lambda horizons: (every_step(states, histories, horizons), None)


@dataclass(frozen=True)
class ReplayTrial:
    """All policies play the shots of a set with one forecaster.

    ``record`` says whether the first policy's trials are recorded; ``latency`` is what passes
    between an action and the arm, s.
    """

    shots: ReplaySet
    histories: Histories
    forecaster: Forecaster
    policies: Policies
    goals: Goals
    record: bool = False
    latency: float = 0.0

    def run(self) -> Played:
        """Return each shot's outcome and forecast error with each policy."""
        shots = self.shots
        with one_thread():
            forecasts = self.forecaster.forecasts(self.histories)
        played, tables = [], []
        for number, (policy, trained) in enumerate(self.policies):
            forecast = forecasts(trained.horizons)
            incoming = IncomingBalls(shots.path, shots.playable, FIRST_WINDOW, *forecast)
            recorded = len(shots) if self.record and not number else 0
            result = play_policy(
                policy, trained, shots.simulator, incoming, self.goals, recorded, self.latency
            )
            played.append(result)
            tables.append(with_states(result.table, result.after_racket, result.before_landing))
        table = pd.concat(tables, ignore_index=True).assign(
            set=shots.name,
            recording=np.tile(np.asarray(shots.recordings), len(played)),
            predictor=self.forecaster.name,
            protocol=str(self.forecaster.mode),
        )
        return Played(table, played[0] if self.record else None)


def load_players(folder: Path, settings: Sim2RealSettings) -> Policies:
    """Read the policies of sim2real: of one group, trained in one simulator.

    Args:
        folder: of all trained policies.
        settings: name group and simulator.

    Raises:
        InputError: there is none, or a file is broken.
    """
    group = load_policies(folder, settings.group)
    policies = [
        (policy, trained) for policy, trained in group if trained.simulator == settings.simulator
    ]
    if not policies:
        problem = f"has no policy of {settings.group} that was trained in {settings.simulator}"
        raise InputError(folder, problem, field="sim2real.simulator")
    return policies


def replay_trials(
    shots: ReplaySet,
    forecasters: Iterable[Forecaster],
    policies: Policies,
    seed: int,
    recorded: Collection[str] = (),
) -> list[ReplayTrial]:
    """Return the trials of a set, all with the same goals.

    Args:
        shots: the set.
        forecasters: one trial each.
        policies: with the same distribution of goals.
        seed: of the goals.
        recorded: names of predictors; with these at every control step, the first policy's trials
            are recorded.
    """
    random = np.random.default_rng([*trial_seed(seed), *shots.name.encode()])
    goals = draw_goals(policies[0][1].goals, len(shots), random)
    histories = measurement_histories(shots.shots)
    return [
        ReplayTrial(
            shots,
            histories,
            forecaster,
            policies,
            goals,
            record=forecaster.name in recorded and forecaster.mode == EVERY_STEP,
        )
        for forecaster in forecasters
    ]


def informed_predictors(
    shots: ReplaySet, learned: Iterable[NamedPredictor], amended: Simulator | None
) -> dict[str, ProbabilisticPredictor]:
    """Return the predictors that know more about a set than the policies' own simulator, by name.

    The learned ones, physics with the amended simulator, and the oracle, where available.
    """
    informed = {named.name: named.predictor for named in learned}
    for name, simulator in ((AMENDED, amended), (ORACLE, shots.oracle)):
        if simulator is not None:
            informed[name] = PhysicsPredictor(simulator)
    return informed


def source_of(shots: ReplaySet) -> str:
    """Return the source of a set: the arena has several sets."""
    return ARENA if shots.name in ARENA_SETS else shots.name


def trial_seed(seed: int) -> list[int]:
    """Return the seed of sim2real's random draws, which no training uses."""
    return [seed, *b"sim2real"]


def tolerance_trials(run: StageRun, policies: Policies) -> list[Callable[[], Played]]:
    """Return the trials of all policies with all errors.

    Policies play shots of their own simulators. All trials of a policy have the same shots; errors
    of all sizes have the same directions.
    """
    settings = run.params.sim2real.tolerance
    errors = [(kind, size / 100) for kind in ("bias", "noise") for size in settings.errors_cm]
    return [
        partial(_play, policy, trained, error, size, settings.shots, trial_seed(run.seed))
        for policy, trained in policies
        for error, size in [*errors, ("no_spin", 0.0)]
    ]


def _play(
    policy: Policy, trained: TrainedPolicy, error: str, size: float, shots: int, seed: Sequence[int]
) -> Played:
    """Return how shots end with an error of ``perturbed``, of a size in m."""
    task, random = trained.task, np.random.default_rng(seed)
    balls, goals = task.draw(shots, random)
    forecasts = perturbed(balls.forecasts, error, size, random)
    incoming = IncomingBalls(balls.path, balls.playable, balls.start, forecasts)
    table = play_policy(policy, trained, task.simulator, incoming, goals).table
    return Played(table.assign(error=error, size_cm=100 * size))
