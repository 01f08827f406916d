"""Trials of sim-to-sim: policies play test shots of the ground truth with two predictors."""

from collections.abc import Sequence
from dataclasses import dataclass

from rallygap.models.ball.simulator import Simulator
from rallygap.models.ball.types import Floats
from rallygap.models.policy.forecasts import first_state, re_anchored
from rallygap.models.policy.goals import Goals, draw_goals
from rallygap.models.policy.incoming_balls import IncomingBalls, fly_incoming
from rallygap.models.policy.launches import draw_launches
from rallygap.models.policy.policy import Policy
from rallygap.models.policy.random_streams import evaluation_stream
from rallygap.models.policy.settings import GoalSettings, HorizonsMs
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

    def forecast(
        self, predictor: Simulator, protocol: Sim2SimProtocol, horizons: HorizonsMs
    ) -> IncomingBalls:
        """Return the shots with the forecasts of a simulator."""
        if protocol == "first_state":
            forecasts = first_state(predictor, self.path[:, 0], horizons)
        else:
            forecasts = re_anchored(predictor, self.path, horizons)
        return IncomingBalls(self.path, self.playable, 0.0, forecasts)


@dataclass(frozen=True)
class Sim2SimTrial:
    """A policy plays the test shots with one predictor.

    Attributes:
        shots: the test shots.
        policy: decides.
        trained: its description.
        protocol: of the predictions.
        name: of the predictor, ``GROUND_TRUTH`` or ``IMPERFECT``.
        predictor: its simulator.
    """

    shots: EvaluationShots
    policy: Policy
    trained: TrainedPolicy
    protocol: Sim2SimProtocol
    name: str
    predictor: Simulator

    def run(self) -> Played:
        """Return how each shot ended."""
        shots, trained = self.shots, self.trained
        incoming = shots.forecast(self.predictor, self.protocol, trained.horizons)
        result = play_policy(self.policy, trained, shots.simulator, incoming, shots.goals)
        return Played(
            result.table.assign(
                protocol=self.protocol, simulator=trained.simulator, predictor=self.name
            )
        )


def sim2sim_trials(
    run: StageRun, policies: Sequence[tuple[Policy, TrainedPolicy]]
) -> list[Sim2SimTrial]:
    """Return the trials of all policies with all protocols and both predictors."""
    shots = _evaluation_shots(run, policies[0][1].goals)
    return [
        Sim2SimTrial(shots, policy, trained, protocol, name, predictor)
        for protocol in run.params.sim2sim.protocols
        for policy, trained in policies
        for name, predictor in (
            (GROUND_TRUTH, shots.simulator),
            (IMPERFECT, trained.task.simulator),
        )
    ]


def _evaluation_shots(run: StageRun, goals: GoalSettings) -> EvaluationShots:
    settings, random = run.params.sim2sim, evaluation_stream(run.seed)
    truth = load_simulator(settings.ground_truth)
    flown = fly_incoming(truth, draw_launches(truth, settings.episodes, random))
    return EvaluationShots(truth, *flown, draw_goals(goals, settings.episodes, random))
