"""Runs trials of trained policies in parallel."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace

import numpy as np
import pandas as pd

from rallygap.models.ball.simulator import Simulator
from rallygap.models.policy.forecasts import forecast_error
from rallygap.models.policy.goals import Goals
from rallygap.models.policy.incoming_balls import IncomingBalls
from rallygap.models.policy.policy import Policy
from rallygap.models.policy.trial import TrialResult, play
from rallygap.pipeline.policies.storage import TrainedPolicy
from rallygap.pipeline.runtime.parallel import parallel


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
