"""Trials of trained policies in parallel; those of sim2sim."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from functools import partial

import numpy as np
import pandas as pd

from rallygap.models.ball.simulator import Simulator
from rallygap.models.policy.forecasts import first_state, forecast_error, re_anchored
from rallygap.models.policy.goals import Goals, draw_goals
from rallygap.models.policy.incoming_balls import IncomingBalls, fly_incoming
from rallygap.models.policy.launches import draw_launches
from rallygap.models.policy.policy import Policy
from rallygap.models.policy.random_streams import evaluation_stream
from rallygap.models.policy.trial import TrialResult, play
from rallygap.pipeline.io.simulators import load_simulator
from rallygap.pipeline.params import Sim2SimProtocol
from rallygap.pipeline.policies.storage import TrainedPolicy
from rallygap.pipeline.runtime.parallel import parallel
from rallygap.pipeline.runtime.stage_run import StageRun

GROUND_TRUTH, IMPERFECT = "ground_truth", "imperfect"  # predictors of sim2sim


@dataclass(frozen=True)
class Played:
    """Results of a trial.

    Attributes:
        table: one row per policy and shot.
        recorded: the first policy's trials with their motions, where they were recorded.
    """

    table: pd.DataFrame
    recorded: TrialResult | None = None


def run_trials(trials: Sequence[Callable[[], Played]]) -> list[Played]:
    """Run trials in parallel processes; return their results in the same order."""
    return list(parallel(trials, "trials"))


def joined(results: Sequence[Played]) -> pd.DataFrame:
    """Return the tables of all results as one."""
    return pd.concat([result.table for result in results], ignore_index=True)


def play_policy(
    policy: Policy,
    trained: TrainedPolicy,
    simulator: Simulator,
    incoming: IncomingBalls,
    goals: Goals,
    record: int = 0,
    latency: float = 0.0,
) -> TrialResult:
    """Let a policy play balls, and label the results.

    Args:
        policy: decides.
        trained: its description.
        simulator: flies the balls on from the racket.
        incoming: (B,) balls with forecasts at the policy's horizons.
        goals: (B,) of their returns.
        record: how many of the first balls to record.
        latency: s from an action to the arm.

    Returns:
        The trials; the table also has ``horizons_ms`` and ``repeat`` of the policy, the number of
        the ``ball``, and ``forecast_error_m``, the same in all rows.
    """
    result = play(policy, simulator, incoming, goals, trained.observation, record, latency)
    table = result.table.assign(
        horizons_ms=trained.horizons_label,
        repeat=trained.repeat,
        ball=np.arange(len(incoming)),
        forecast_error_m=forecast_error(incoming, trained.horizons),
    )
    return replace(result, table=table)


def sim2sim_trials(
    run: StageRun, policies: Sequence[tuple[Policy, TrainedPolicy]]
) -> list[Callable[[], Played]]:
    """Return the trials of all policies with all protocols and both predictors.

    Every policy plays the same shots; the ground truth flies them, to the robot and back.
    """
    settings, random = run.params.sim2sim, evaluation_stream(run.seed)
    truth = load_simulator(settings.ground_truth)
    path, playable = fly_incoming(truth, draw_launches(truth, settings.episodes, random))
    goals = draw_goals(policies[0][1].goals, settings.episodes, random)

    def play(
        protocol: Sim2SimProtocol,
        policy: Policy,
        trained: TrainedPolicy,
        name: str,
        predictor: Simulator,
    ) -> Played:
        if protocol == "first_state":
            forecasts = first_state(predictor, path[:, 0], trained.horizons)
        else:
            forecasts = re_anchored(predictor, path, trained.horizons)
        incoming = IncomingBalls(path, playable, 0.0, forecasts)
        table = play_policy(policy, trained, truth, incoming, goals).table
        return Played(table.assign(protocol=protocol, simulator=trained.simulator, predictor=name))

    return [
        partial(play, protocol, policy, trained, name, predictor)
        for protocol in settings.protocols
        for policy, trained in policies
        for name, predictor in ((GROUND_TRUTH, truth), (IMPERFECT, trained.task.simulator))
    ]
