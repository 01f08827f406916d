"""Sim-to-real: policies from an imperfect simulator play measured balls, replayed to them."""

from typing import Any

import numpy as np
import pandas as pd

from models.policy.goals import draw_goals
from models.policy.policy import Policy
from models.policy.replay import views
from models.predictors.physics import PhysicsPredictor
from pipeline.artifacts import write_table
from pipeline.errors import InputError
from pipeline.figures.sim2real import tolerance_figure, transfer_figure
from pipeline.metrics import place, rounded
from pipeline.outcomes import differences, rates
from pipeline.policies import TrainedPolicy, load_policies
from pipeline.predictors import ORACLE, Contender, read_trained
from pipeline.replay_trials import (
    EveryTick,
    FirstWindow,
    Forecaster,
    ReplayTrial,
    ToleranceTrial,
)
from pipeline.replays import ReplaySet, read_replay_sets
from pipeline.run import StageRun, run_stage
from pipeline.simulators import load_simulator
from pipeline.transfer import BASELINE, PHYSICS, SETTING, in_the_form_of_the_paper
from pipeline.trials import play_all

KEYS = [*SETTING, *BASELINE]  # what tells two experiments apart

Policies = list[tuple[Policy, TrainedPolicy]]


def sim2real(run: StageRun) -> None:
    """Replay measured balls to policies, with every predictor; then spoil their forecasts."""
    policies = _policies(run)
    sets = read_replay_sets(run.root / "artifacts", run.params.sim2real, run.seed)
    for one in sets:
        run.log_input(one.name, run.input("segment", "episodes.parquet"), len(one))
    learned = list(read_trained(run.input("train_predictor", "")))
    replayed = play_all([trial for one in sets for trial in _replays(run, one, policies, learned)])
    write_table(run.artifact("played.parquet"), replayed)
    tolerated = play_all(_spoilt(run, policies))
    _report_transfer(run, replayed, [one.name for one in learned])
    _report_sets(run, sets)
    _report_tolerance(run, tolerated)


def _policies(run: StageRun) -> Policies:
    """Return the policies of the group that were trained in the simulator."""
    settings, folder = run.params.sim2real, run.input("train_policy", "")
    group = load_policies(folder, settings.group)
    policies = [one for one in group if one[1].simulator == settings.simulator]
    if not policies:
        problem = f"has no policy of {settings.group} that was trained in {settings.simulator}"
        raise InputError(folder, problem, field="sim2real.simulator")
    run.log_input(f"policies of {settings.group}", folder, len(policies))
    return policies


def _replays(
    run: StageRun, one: ReplaySet, policies: Policies, learned: list[Contender]
) -> list[ReplayTrial]:
    """Return the trials of a set: physics, what was learned, and the oracle where there is one."""
    physics = load_simulator(run.params.sim2real.simulator)
    forecasters: list[Forecaster] = [
        FirstWindow(PHYSICS, physics),
        EveryTick(PHYSICS, PhysicsPredictor(physics)),
        *(EveryTick(other.name, other.predictor) for other in learned),
    ]
    if one.oracle is not None:
        forecasters.append(EveryTick(ORACLE, PhysicsPredictor(one.oracle)))
    random = np.random.default_rng([*_stream(run), *one.name.encode()])
    goals, seen = draw_goals(policies[0][1].goals, len(one), random), views(one.shots)
    return [ReplayTrial(one, seen, forecaster, policies, goals) for forecaster in forecasters]


def _spoilt(run: StageRun, policies: Policies) -> list[ToleranceTrial]:
    settings = run.params.sim2real.tolerance
    errors = [(kind, size / 100) for kind in ("bias", "noise") for size in settings.errors_cm]
    return [
        ToleranceTrial(policy, trained, error, size, settings.balls, _stream(run))
        for policy, trained in policies
        for error, size in [*errors, ("no_spin", 0.0)]
    ]


def _stream(run: StageRun) -> list[int]:
    """Return the seed of draws that no training makes."""
    return [run.seed, *run.stage.encode()]


def _report_transfer(run: StageRun, replayed: pd.DataFrame, learned: list[str]) -> None:
    resamples = run.params.sim2real.bootstrap_resamples
    table = rates(replayed, KEYS, resamples, run.seed)
    errors = replayed.groupby(KEYS, sort=False)["forecast_error_m"].mean()
    table["forecast_error_cm"] = 100 * errors.to_numpy()
    gains = differences(replayed, SETTING, BASELINE, resamples, run.seed)
    run.write_metrics(_metrics(table, gains))
    run.add_figure(
        transfer_figure(table),
        "transfer",
        title="Sim-to-real: hits and returns of replayed shots",
        caption=_experiment(run),
    )
    run.add_table(
        in_the_form_of_the_paper(table, learned),
        "transfer",
        title="Sim-to-real, in the form of the paper's table",
        caption=f"{_experiment(run)} Numbers of shots, means over policies that differ in nothing "
        "but the seed. Physics and the learned predictor are both asked at every tick. The "
        "paper's shots are other ones, and so are its robot and its policy: what can be set beside "
        "each other is what the learned predictor gains.",
    )
    run.add_table(
        table,
        "rates",
        title="Sim-to-real: all predictors",
        caption="Shares of the replayed shots with their 95 % intervals (low, high), bootstrapped "
        "over shots; hits and returns in numbers, means over policies. forecast_error_cm: mean "
        "distance between forecast and true position at the middle horizon, over all control "
        "ticks before the ball is gone.",
    )
    run.add_table(
        gains,
        "difference",
        title="Sim-to-real: what predictors gain over physics at every tick",
        caption="Share of the shots with the predictor minus that with physics, on the same shots, "
        "with its 95 % interval bootstrapped over shots. gained, lost: shots that ended so more "
        "often with the one, or with the other.",
    )


def _experiment(run: StageRun) -> str:
    settings = run.params.sim2real
    return (
        f"Policies that were trained in the simulator {settings.simulator} play measured shots. "
        "Physics is a Kalman filter over the last 12 measurements with that simulator: first "
        "window, the whole flight forecast at once from the first 12 measurements; every tick, "
        "anew every 40 ms, as all other predictors do. The oracle knows the physics that flew the "
        "ball. Off the racket, simulated balls fly on in their own hall's physics, measured ones "
        "in the literature's."
    )


def _report_sets(run: StageRun, sets: list[ReplaySet]) -> None:
    rows = [
        {
            "set": one.name,
            "replayed": len(one),
            "in_reach": one.in_reach,
            "turned": one.turned,
            "left_out": ", ".join(f"{count} {why}" for why, count in one.left_out.items()) or None,
            "spin": one.spin,
            "flown_on_by": "the physics that flew them" if one.oracle else "the literature",
        }
        for one in sets
    ]
    run.add_table(
        pd.DataFrame(rows),
        "replayed",
        title="Shots that are replayed",
        caption="Shots that no predictor has learned from. in_reach: those that come to where the "
        "racket strikes well, fast or slow; nothing is done about the others. turned: those that "
        "flew the other way and were turned by half a turn. left_out: with the reason. spin: how "
        "it was measured; without a label a ball starts without spin, and what its bounce turned "
        "is told by the change of its velocity.",
    )


def _report_tolerance(run: StageRun, tolerated: pd.DataFrame) -> None:
    settings = run.params.sim2real
    keys = ["error", "size_cm", "horizons_ms"]
    table = rates(tolerated, keys, settings.bootstrap_resamples, run.seed)
    caption = (
        f"{settings.tolerance.balls} unseen balls of the policies' own simulator, forecast exactly "
        "but for one error. bias: every position of a ball's forecasts off by so much in one "
        "direction, drawn anew for each ball; noise: off anew at every tick, by so much in the "
        "root mean square; no_spin: told as zero. 95 % intervals are bootstrapped over balls."
    )
    title = "How wrong a forecast the policies tolerate"
    run.add_figure(tolerance_figure(table), "tolerance", title=title, caption=caption)
    run.add_table(table, "tolerance", title=title, caption=caption)


def _metrics(table: pd.DataFrame, gains: pd.DataFrame) -> dict[str, Any]:
    """Return ``{set: {horizons: {predictor: {protocol: numbers}}}}``.

    Numbers are those of the tables, and of ``gained_returns`` and ``gained_hits`` over physics.
    """
    metrics: dict[str, Any] = {}
    for row in table.to_dict("records"):
        place(metrics, _keys(row)).update(_numbers(row))
    for row in gains.to_dict("records"):
        place(metrics, [*_keys(row), f"gained_{row['outcome']}"]).update(_numbers(row))
    return metrics


def _keys(row: dict[Any, Any]) -> list[str]:
    return [row[key] for key in KEYS]


def _numbers(row: dict[Any, Any]) -> dict[str, float]:
    return {name: rounded(value) for name, value in row.items() if name not in (*KEYS, "outcome")}


if __name__ == "__main__":
    run_stage(sim2real)
