"""Trials of sim-to-sim: policies play test shots of the ground truth with two predictors."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import partial

from rallygap.models.ball.simulator import Simulator
from rallygap.models.ball.types import Floats
from rallygap.models.policy.forecasts import first_state, re_anchored
from rallygap.models.policy.goals import Goals, draw_goals
from rallygap.models.policy.incoming_balls import IncomingBalls, fly_incoming
from rallygap.models.policy.launches import draw_launches
from rallygap.models.policy.policy import Policy
from rallygap.models.policy.random_streams import evaluation_stream
from rallygap.pipeline.io.simulators import load_simulator
from rallygap.pipeline.params import Sim2SimProtocol
from rallygap.pipeline.policies.storage import TrainedPolicy
from rallygap.pipeline.runtime.stage_run import StageRun
from rallygap.pipeline.transfer.trials import Played, play_policy

GROUND_TRUTH, IMPERFECT = "ground_truth", "imperfect"  # predictors


@dataclass(frozen=True)
class EvaluationShots:
    """The shots that every policy plays with every predictor.

    Attributes:
        simulator: flies them, to the robot and back.
        path: (B, N, 9) true states as in ``IncomingBalls``.
        playable: (B, 2) s, as there.
        goals: (B,) of their returns.
    """

    simulator: Simulator
    path: Floats
    playable: Floats
    goals: Goals

    def play(
        self,
        policy: Policy,
        trained: TrainedPolicy,
        protocol: Sim2SimProtocol,
        name: str,
        predictor: Simulator,
    ) -> Played:
        """Let a policy play the shots; return how each ended.

        Args:
            policy: decides.
            trained: its description.
            protocol: of the predictions.
            name: of the predictor, ``GROUND_TRUTH`` or ``IMPERFECT``.
            predictor: its simulator.
        """
        if protocol == "first_state":
            forecasts = first_state(predictor, self.path[:, 0], trained.horizons)
        else:
            forecasts = re_anchored(predictor, self.path, trained.horizons)
        incoming = IncomingBalls(self.path, self.playable, 0.0, forecasts)
        table = play_policy(policy, trained, self.simulator, incoming, self.goals).table
        return Played(table.assign(protocol=protocol, simulator=trained.simulator, predictor=name))


def sim2sim_trials(
    run: StageRun, policies: Sequence[tuple[Policy, TrainedPolicy]]
) -> list[Callable[[], Played]]:
    """Return the trials of all policies with all protocols and both predictors."""
    settings, random = run.params.sim2sim, evaluation_stream(run.seed)
    truth = load_simulator(settings.ground_truth)
    path, playable = fly_incoming(truth, draw_launches(truth, settings.episodes, random))
    goals = draw_goals(policies[0][1].goals, settings.episodes, random)
    shots = EvaluationShots(truth, path, playable, goals)
    return [
        partial(shots.play, policy, trained, protocol, name, predictor)
        for protocol in settings.protocols
        for policy, trained in policies
        for name, predictor in ((GROUND_TRUTH, truth), (IMPERFECT, trained.task.simulator))
    ]
