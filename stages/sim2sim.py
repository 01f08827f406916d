"""Sim-to-sim: policies from imperfect simulators play in another, which counts as the truth."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
import pandas as pd
from joblib import Parallel, delayed
from numpy.typing import NDArray

from models.ball.simulator import Simulator
from models.policy.comparison import Comparison, compare, forecast_error
from models.policy.forecasts import first_state, re_anchored
from models.policy.goals import Goals, draw_goals
from models.policy.incoming import Incoming, fly_in
from models.policy.launches import draw_launches
from models.policy.policy import Policy
from models.policy.settings import HorizonsMs
from models.policy.streams import unseen_balls
from models.policy.trial import play
from pipeline.figures.sim2sim import GROUND_TRUTH, IMPERFECT, PROTOCOLS, sim2sim_figure
from pipeline.params import Sim2SimProtocol
from pipeline.policies import TrainedPolicy, load_policies
from pipeline.progress import progress_bar
from pipeline.run import StageRun, run_stage
from pipeline.simulators import load_simulator

SETTING = ["protocol", "simulator", "horizons_ms"]  # what tells two comparisons apart


@dataclass(frozen=True)
class Exam:
    """The balls that every policy plays, whatever it is told of them.

    Attributes:
        simulator: flies them, to the robot and back.
        launches: (B, 9) states.
        goals: (B,) of their returns.
    """

    simulator: Simulator
    launches: NDArray[np.float64]
    goals: Goals

    def told(
        self, forecaster: Simulator, protocol: Sim2SimProtocol, horizons: HorizonsMs
    ) -> Incoming:
        """Return the balls with what a simulator says of them."""
        path, playable = fly_in(self.simulator, self.launches)
        if protocol == "first_state":
            forecasts = first_state(forecaster, self.launches, horizons)
        else:
            forecasts = re_anchored(forecaster, path, horizons)
        return Incoming(path, playable, 0.0, forecasts)


@dataclass(frozen=True)
class Trial:
    """A policy that sits the exam.

    Attributes:
        policy: decides.
        trained: what it was trained for.
        protocol: of the predictions.
        predictor: who makes them, ``GROUND_TRUTH`` or ``IMPERFECT``, ...
        forecaster: ... and with what.
    """

    policy: Policy
    trained: TrainedPolicy
    protocol: Sim2SimProtocol
    predictor: str
    forecaster: Simulator

    def results(self, exam: Exam) -> pd.DataFrame:
        """Return one row a ball: whether it was hit and returned, and what trial that was."""
        trained = self.trained
        told = exam.told(self.forecaster, self.protocol, trained.horizons)
        played = play(self.policy, exam.simulator, told, exam.goals, trained.observation)
        return played[["hit", "returned"]].assign(
            protocol=self.protocol,
            simulator=trained.simulator,
            horizons_ms=f"{trained.horizons[0]}-{trained.horizons[-1]}",
            predictor=self.predictor,
            repeat=trained.repeat,
            ball=np.arange(len(played)),
            forecast_error_m=forecast_error(told, trained.horizons),
        )


def sim2sim(run: StageRun) -> None:
    """Let every policy play the same balls, told of them by the truth and by its own simulator."""
    settings, folder = run.params.sim2sim, run.input("train_policy", "")
    policies = load_policies(folder, settings.group)
    run.log_input(f"policies of {settings.group}", folder, len(policies))
    truth = load_simulator(settings.ground_truth)
    random = unseen_balls(run.seed)
    launches = draw_launches(truth, settings.episodes, random)
    goals = draw_goals(policies[0][1].goals, settings.episodes, random)
    trials = [
        Trial(policy, trained, protocol, predictor, forecaster)
        for protocol in settings.protocols
        for policy, trained in policies
        for predictor, forecaster in ((GROUND_TRUTH, truth), (IMPERFECT, trained.task.simulator))
    ]
    played = pd.concat(_played(trials, Exam(truth, launches, goals)), ignore_index=True)
    _report(run, played)


def _played(trials: Sequence[Trial], exam: Exam) -> list[pd.DataFrame]:
    """Return the results of all trials, in their order, played on all cores."""
    tables = []
    with progress_bar("trials", len(trials)) as advance:
        parallel = Parallel(n_jobs=-1, return_as="generator")
        for table in parallel(delayed(trial.results)(exam) for trial in trials):
            tables.append(table)
            advance()
    return tables


def _report(run: StageRun, played: pd.DataFrame) -> None:
    comparisons = {
        setting: _comparison(run, rows) for setting, rows in played.groupby(SETTING, sort=False)
    }
    rates = _rates(played, comparisons)
    run.write_metrics(_metrics(rates, comparisons))
    run.add_figure(
        sim2sim_figure(rates),
        "return_rate",
        title="Sim-to-sim transfer",
        caption=f"{_experiment(run)} Whiskers: 95 % interval, bootstrapped over balls. "
        "Dots, where there are several: single policies that differ in nothing but the seed.",
    )
    _add_rate_table(run, rates)
    _add_difference_table(run, comparisons)


def _comparison(run: StageRun, rows: pd.DataFrame) -> Comparison:
    """Compare the predictors, ball by ball, under the policies of one setting."""
    returned = {
        str(predictor): part.pivot(index="repeat", columns="ball", values="returned").to_numpy()
        for predictor, part in rows.groupby("predictor")
    }
    resamples = run.params.sim2sim.bootstrap_resamples
    return compare(returned[GROUND_TRUTH], returned[IMPERFECT], resamples, run.seed)


def _rates(played: pd.DataFrame, comparisons: dict[Any, Comparison]) -> pd.DataFrame:
    """Return one row a protocol, simulator, horizons and predictor."""
    rows = []
    for key, part in played.groupby([*SETTING, "predictor"], sort=False):
        *setting, predictor = key
        compared = comparisons[tuple(setting)]
        interval = compared.one if predictor == GROUND_TRUTH else compared.other
        per_seed = part.groupby("repeat")["returned"].mean()
        row = {
            **dict(zip([*SETTING, "predictor"], key, strict=True)),
            "return_rate": interval.mean,
            "std": per_seed.std(ddof=0),
            "per_seed": [_rounded(rate) for rate in per_seed],
            "ci_low": interval.low,
            "ci_high": interval.high,
            "hit_rate": part["hit"].mean(),
            "forecast_error_m": round(part["forecast_error_m"].mean(), 6),
        }
        rows.append(row)
    return pd.DataFrame(rows)


def _metrics(rates: pd.DataFrame, comparisons: dict[Any, Comparison]) -> dict[str, Any]:
    """Return ``{protocol: {simulator: {horizons: {predictor: {...}, "difference": {...}}}}}``."""
    metrics: dict[str, Any] = {}
    for row in rates.to_dict("records"):
        place = metrics
        for name in SETTING:
            place = place.setdefault(row[name], {})
        spread = {"mean": _rounded(row["return_rate"]), "std": _rounded(row["std"])}
        place[row["predictor"]] = {
            "return_rate": {**spread, "per_seed": row["per_seed"]},
            "hit_rate": _rounded(row["hit_rate"]),
        }
    for (protocol, simulator, horizons), compared in comparisons.items():
        ends = vars(compared.difference).items()
        difference = {name: _rounded(value) for name, value in ends}
        metrics[protocol][simulator][horizons]["difference"] = difference
    return metrics


def _rounded(value: float) -> float:
    """Six digits: more would only show the processor's last bits."""
    return float(f"{value:.6g}")


def _experiment(run: StageRun) -> str:
    settings = run.params.sim2sim
    protocols = "; ".join(f"{name}: {PROTOCOLS[name]}" for name in settings.protocols)
    return (
        "Policies that were trained in an imperfect simulator, balls and predictions alike, play "
        f"the same {settings.episodes} unseen balls of the simulator {settings.ground_truth}, "
        "which flies them to the robot and back. What they are told of each ball is predicted by "
        f"that ground truth or by their own imperfect simulator. {protocols}."
    )


def _add_rate_table(run: StageRun, rates: pd.DataFrame) -> None:
    run.add_table(
        rates.drop(columns="per_seed"),
        "return_rate",
        title="Sim-to-sim: returns, hits and forecast errors",
        caption=f"{_experiment(run)} Shares of the balls; ci: 95 % interval of the return rate, "
        "bootstrapped over balls; std: over policies that differ in nothing but the seed; "
        "forecast_error_m: mean distance between predicted and true position at the middle "
        "horizon, over all control ticks before the ball is gone.",
    )


def _add_difference_table(run: StageRun, comparisons: dict[Any, Comparison]) -> None:
    rows = [
        {
            **dict(zip(SETTING, setting, strict=True)),
            "difference": compared.difference.mean,
            "ci_low": compared.difference.low,
            "ci_high": compared.difference.high,
            "gained": compared.gained,
            "lost": compared.lost,
        }
        for setting, compared in comparisons.items()
    ]
    run.add_table(
        pd.DataFrame(rows),
        "difference",
        title="Sim-to-sim: what the ground truth's predictions gain",
        caption="Return rate with the ground truth's predictions minus that with the imperfect "
        "simulator's, on the same balls, with its 95 % interval bootstrapped over balls. gained, "
        "lost: balls returned more often with the one, or with the other.",
    )


if __name__ == "__main__":
    run_stage(sim2sim)
