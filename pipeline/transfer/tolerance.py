"""Which forecast errors policies tolerate: trials with deliberate errors."""

from collections.abc import Callable, Sequence
from functools import partial

import numpy as np

from rallygap.models.policy.incoming_balls import IncomingBalls
from rallygap.models.policy.policy import Policy
from rallygap.models.replay.perturbed_forecasts import ERRORS
from rallygap.pipeline.policies.storage import TrainedPolicy
from rallygap.pipeline.runtime.stage_run import StageRun
from rallygap.pipeline.transfer.replay_trials import Policies, trial_seed
from rallygap.pipeline.transfer.trials import Played, play_policy


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
    policy: Policy,
    trained: TrainedPolicy,
    error: str,
    size: float,
    shots: int,
    seed: Sequence[int],
) -> Played:
    """Return how shots end with a key of ``ERRORS``, of a size in m."""
    task, random = trained.task, np.random.default_rng(seed)
    balls, goals = task.draw(shots, random)
    forecasts = ERRORS[error](balls.forecasts, size, random)
    incoming = IncomingBalls(balls.path, balls.playable, balls.start, forecasts)
    table = play_policy(policy, trained, task.simulator, incoming, goals).table
    return Played(table.assign(error=error, size_cm=100 * size))
