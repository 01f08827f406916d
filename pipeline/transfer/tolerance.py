"""Which forecast errors policies tolerate: trials with deliberate errors."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from rallygap.models.policy.incoming_balls import IncomingBalls
from rallygap.models.policy.policy import Policy
from rallygap.models.replay.perturbed_forecasts import ERRORS
from rallygap.pipeline.policies.storage import TrainedPolicy
from rallygap.pipeline.runtime.stage_run import StageRun
from rallygap.pipeline.transfer.replay_trials import Policies, trial_seed
from rallygap.pipeline.transfer.trials import Played, play_policy


@dataclass(frozen=True)
class ToleranceTrial:
    """A policy plays shots of its own simulator with one kind of forecast error.

    All trials of a policy have the same shots; errors of all sizes have the same directions.

    Attributes:
        policy: plays.
        trained: its description.
        error: key of ``ERRORS``.
        size: of the error, m.
        shots: how many.
        seed: of shots, goals and errors.
    """

    policy: Policy
    trained: TrainedPolicy
    error: str
    size: float
    shots: int
    seed: Sequence[int]

    def run(self) -> Played:
        """Return how each shot ended."""
        task, random = self.trained.task, np.random.default_rng(self.seed)
        balls, goals = task.draw(self.shots, random)
        forecasts = ERRORS[self.error](balls.forecasts, self.size, random)
        incoming = IncomingBalls(balls.path, balls.playable, balls.start, forecasts)
        result = play_policy(self.policy, self.trained, task.simulator, incoming, goals)
        return Played(result.table.assign(error=self.error, size_cm=100 * self.size))


def tolerance_trials(run: StageRun, policies: Policies) -> list[ToleranceTrial]:
    """Return the trials of all policies with all errors."""
    settings = run.params.sim2real.tolerance
    errors = [(kind, size / 100) for kind in ("bias", "noise") for size in settings.errors_cm]
    return [
        ToleranceTrial(policy, trained, error, size, settings.shots, trial_seed(run.seed))
        for policy, trained in policies
        for error, size in [*errors, ("no_spin", 0.0)]
    ]
