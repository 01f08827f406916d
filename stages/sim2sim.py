"""Sim-to-sim: policies from imperfect simulators play in another, which counts as the truth."""

from dataclasses import dataclass
from typing import Any

import numpy as np
import pandas as pd
from numpy.typing import NDArray

from models.ball.simulator import Simulator
from models.policy.forecasts import first_state, re_anchored
from models.policy.goals import Goals, draw_goals
from models.policy.incoming_balls import Incoming, fly_in
from models.policy.launches import draw_launches
from models.policy.policy import Policy
from models.policy.random_streams import unseen_balls
from models.policy.settings import GoalSettings, HorizonsMs
from pipeline.io.metrics import over_seeds, place, rounded
from pipeline.io.simulators import load_simulator
from pipeline.params import Sim2SimProtocol
from pipeline.policies.storage import TrainedPolicy, load_policies
from pipeline.runtime.stage_run import StageRun, run_stage
from pipeline.transfer.figures.sim2sim import GROUND_TRUTH, IMPERFECT, PROTOCOLS, sim2sim_figure
from pipeline.transfer.rates import differences, rates
from pipeline.transfer.trials import play_all, try_policy

SETTING = ["protocol", "simulator", "horizons_ms"]  # what tells two comparisons apart
BASELINE = {"predictor": IMPERFECT}  # what the ground truth's predictions are compared with
KEYS = [*SETTING, *BASELINE]
INTERVAL = {"return_rate_low": "ci_low", "return_rate_high": "ci_high"}
RATES = ["return_rate", "std", "ci_low", "ci_high", "hit_rate", "forecast_error_m"]


@dataclass(frozen=True)
class Exam:
    """The balls that every policy plays, whatever it is told of them.

    Attributes:
        simulator: flies them, to the robot and back.
        path: (B, N, 9) their true states as in ``Incoming``.
        playable: (B, 2) s, as there.
        goals: (B,) of their returns.
    """

    simulator: Simulator
    path: NDArray[np.float64]
    playable: NDArray[np.float64]
    goals: Goals

    def told(
        self, forecaster: Simulator, protocol: Sim2SimProtocol, horizons: HorizonsMs
    ) -> Incoming:
        """Return the balls with what a simulator says of them."""
        if protocol == "first_state":
            forecasts = first_state(forecaster, self.path[:, 0], horizons)
        else:
            forecasts = re_anchored(forecaster, self.path, horizons)
        return Incoming(self.path, self.playable, 0.0, forecasts)


@dataclass(frozen=True)
class ExamTrial:
    """A policy that sits the exam.

    Attributes:
        exam: the balls.
        policy: decides.
        trained: what it was trained for.
        protocol: of the predictions.
        predictor: who makes them, ``GROUND_TRUTH`` or ``IMPERFECT``, ...
        forecaster: ... and with what.
    """

    exam: Exam
    policy: Policy
    trained: TrainedPolicy
    protocol: Sim2SimProtocol
    predictor: str
    forecaster: Simulator

    def results(self) -> pd.DataFrame:
        """Return how each ball ended, and what trial that was."""
        exam, trained = self.exam, self.trained
        told = exam.told(self.forecaster, self.protocol, trained.horizons)
        return try_policy(self.policy, trained, exam.simulator, told, exam.goals).assign(
            protocol=self.protocol, simulator=trained.simulator, predictor=self.predictor
        )


def sim2sim(run: StageRun) -> None:
    """Let every policy play the same balls, told of them by the truth and by its own simulator."""
    settings, folder = run.params.sim2sim, run.input("train_policy", "")
    policies = load_policies(folder, settings.group)
    run.log_input(f"policies of {settings.group}", folder, len(policies))
    exam = _exam(run, policies[0][1].goals)
    trials = [
        ExamTrial(exam, policy, trained, protocol, predictor, forecaster)
        for protocol in settings.protocols
        for policy, trained in policies
        for predictor, forecaster in (
            (GROUND_TRUTH, exam.simulator),
            (IMPERFECT, trained.task.simulator),
        )
    ]
    _report(run, play_all(trials))


def _exam(run: StageRun, asked: GoalSettings) -> Exam:
    """Return balls that no policy has learned from, flown by the ground truth."""
    settings, random = run.params.sim2sim, unseen_balls(run.seed)
    truth = load_simulator(settings.ground_truth)
    flown = fly_in(truth, draw_launches(truth, settings.episodes, random))
    return Exam(truth, *flown, draw_goals(asked, settings.episodes, random))


def _report(run: StageRun, played: pd.DataFrame) -> None:
    resamples = run.params.sim2sim.bootstrap_resamples
    table = _rates(played, resamples, run.seed)
    gains = differences(played, SETTING, BASELINE, resamples, run.seed)
    gains = gains[gains["outcome"] == "returns"]
    run.write_metrics(_metrics(table, gains))
    run.add_figure(
        sim2sim_figure(table),
        "return_rate",
        title="Sim-to-sim transfer",
        caption=f"{_experiment(run)} Whiskers: 95 % interval, bootstrapped over balls. "
        "Dots, where there are several: single policies that differ in nothing but the seed.",
    )
    _add_rate_table(run, table)
    _add_difference_table(run, gains)


def _rates(played: pd.DataFrame, resamples: int, seed: int) -> pd.DataFrame:
    """Return ``rates`` of the predictors, with the single policies' and the forecasts' errors."""
    table = rates(played, KEYS, resamples, seed)
    experiments = played.groupby(KEYS, sort=False)
    per_seed = [part.groupby("repeat")["returned"].mean().tolist() for _, part in experiments]
    return table.rename(columns=INTERVAL).assign(
        per_seed=pd.Series(per_seed),
        std=[np.std(each) for each in per_seed],
        # To a micrometre: what the truth forecasts of itself is off by rounding alone.
        forecast_error_m=experiments["forecast_error_m"].mean().round(6).to_numpy(),
    )


def _metrics(table: pd.DataFrame, gains: pd.DataFrame) -> dict[str, Any]:
    """Return ``{protocol: {simulator: {horizons: {predictor: {...}, "difference": {...}}}}}``."""
    metrics: dict[str, Any] = {}
    for row in table.to_dict("records"):
        place(metrics, [row[key] for key in KEYS]).update(
            return_rate=over_seeds(row["per_seed"]), hit_rate=rounded(row["hit_rate"])
        )
    for row in gains.to_dict("records"):
        place(metrics, [*(row[key] for key in SETTING), "difference"]).update(
            mean=rounded(row["difference"]),
            low=rounded(row["ci_low"]),
            high=rounded(row["ci_high"]),
        )
    return metrics


def _experiment(run: StageRun) -> str:
    settings = run.params.sim2sim
    protocols = "; ".join(f"{name}: {PROTOCOLS[name]}" for name in settings.protocols)
    return (
        "Policies that were trained in an imperfect simulator, balls and predictions alike, play "
        f"the same {settings.episodes} unseen balls of the simulator {settings.ground_truth}, "
        "which flies them to the robot and back. What they are told of each ball is predicted by "
        f"that ground truth or by their own imperfect simulator. {protocols}."
    )


def _add_rate_table(run: StageRun, table: pd.DataFrame) -> None:
    run.add_table(
        table[[*KEYS, *RATES]],
        "return_rate",
        title="Sim-to-sim: returns, hits and forecast errors",
        caption=f"{_experiment(run)} Shares of the balls; ci: 95 % interval of the return rate, "
        "bootstrapped over balls; std: over policies that differ in nothing but the seed; "
        "forecast_error_m: mean distance between predicted and true position at the middle "
        "horizon, over all control ticks before the ball is gone.",
    )


def _add_difference_table(run: StageRun, gains: pd.DataFrame) -> None:
    run.add_table(
        gains.drop(columns=["predictor", "outcome"]),
        "difference",
        title="Sim-to-sim: what the ground truth's predictions gain",
        caption="Return rate with the ground truth's predictions minus that with the imperfect "
        "simulator's, on the same balls, with its 95 % interval bootstrapped over balls. gained, "
        "lost: balls returned more often with the one, or with the other.",
    )


if __name__ == "__main__":
    run_stage(sim2sim)
