"""Sim-to-real: policies from an imperfect simulator play measured balls, replayed to them."""

from typing import Any

import pandas as pd

from models.predictors.physics import PhysicsPredictor
from pipeline.evaluation.predictors import NamedPredictor, read_learned
from pipeline.io.amended_simulators import amended_by
from pipeline.io.artifacts import write_json, write_table
from pipeline.io.metrics import place, rounded
from pipeline.io.simulators import load_simulator
from pipeline.runtime.stage_run import StageRun, run_stage
from pipeline.transfer.example_returns import Return, write_returns
from pipeline.transfer.figures.sim2real import tolerance_figure, transfer_figure
from pipeline.transfer.rates import differences, rates
from pipeline.transfer.recorded_returns import chosen, filmed
from pipeline.transfer.replay_sets import ReplaySet, read_replay_sets
from pipeline.transfer.replay_trials import (
    EveryTick,
    FirstWindow,
    Forecaster,
    Policies,
    ReplayTrial,
    ToleranceTrial,
    informed,
    players,
    replays,
    source_of,
    stream,
)
from pipeline.transfer.transfer_table import BASELINE, PHYSICS, SETTING, in_the_form_of_the_paper
from pipeline.transfer.trials import play_all

KEYS = [*SETTING, *BASELINE]  # what tells two experiments apart
FILMED = 2  # balls of every set


def sim2real(run: StageRun) -> None:
    """Replay measured balls to policies, with every predictor; then spoil their forecasts."""
    folder = run.input("train_policy", "")
    policies = players(folder, run.params.sim2real)
    run.log_input(f"policies of {run.params.sim2real.group}", folder, len(policies))
    sets = read_replay_sets(run.root / "artifacts", run.params.sim2real, run.seed)
    for one in sets:
        run.log_input(one.name, run.input("segment", "episodes.parquet"), len(one))
    learned = read_learned(run.input("train_predictor", ""), run.params.sim2real.learned)
    trials = {one.name: _replays(run, one, policies, learned) for one in sets}
    replayed = play_all([trial for own in trials.values() for trial in own])
    write_table(run.artifact("played.parquet"), replayed)
    names = [one.name for one in learned]
    films = [film for own in trials.values() for film in _films(own, replayed, names)]
    write_returns(run.artifact("returns.json"), films)
    write_json(run.artifact("settings.json"), run.params.sim2real.model_dump(mode="json"))
    tolerated = play_all(_spoilt(run, policies))
    _report_transfer(run, replayed, names)
    _report_sets(run, sets)
    _report_tolerance(run, tolerated)


def _replays(
    run: StageRun, one: ReplaySet, policies: Policies, learned: list[NamedPredictor]
) -> list[ReplayTrial]:
    """Return the trials of a set: with physics, and with all who know more."""
    simulator = run.params.sim2real.simulator
    physics = load_simulator(simulator)
    amended = amended_by(run.input("close_gap", ""), source_of(one), simulator)
    forecasters: list[Forecaster] = [
        FirstWindow(PHYSICS, physics),
        EveryTick(PHYSICS, PhysicsPredictor(physics)),
        *informed(one, learned, amended),
    ]
    return replays(one, forecasters, policies, run.seed)


def _films(trials: list[ReplayTrial], replayed: pd.DataFrame, learned: list[str]) -> list[Return]:
    """Film some balls of a set, told by physics and by what forecasts them best of the learned."""
    shots, goals, player = trials[0].shots, trials[0].goals, trials[0].policies[0]
    played = replayed[
        (replayed["set"] == shots.name)
        & (replayed["protocol"] == EveryTick.protocol)
        & (replayed["horizons_ms"] == player[1].horizons_label)
        & (replayed["repeat"] == player[1].repeat)
    ]
    errors = played.groupby("predictor")["forecast_error_m"].mean()
    compared = [PHYSICS, min(learned, key=errors.__getitem__)]
    asked = [one.forecaster for one in trials if isinstance(one.forecaster, EveryTick)]
    tellers = [one for one in asked if one.name in compared]
    balls = chosen(played, compared, FILMED)
    return [film for ball in balls for film in filmed(shots, ball, goals, player, tellers)]


def _spoilt(run: StageRun, policies: Policies) -> list[ToleranceTrial]:
    settings = run.params.sim2real.tolerance
    errors = [(kind, size / 100) for kind in ("bias", "noise") for size in settings.errors_cm]
    return [
        ToleranceTrial(policy, trained, error, size, settings.balls, stream(run.seed))
        for policy, trained in policies
        for error, size in [*errors, ("no_spin", 0.0)]
    ]


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
        "anew every 40 ms, as all other predictors do. Amended is physics with that simulator as "
        "close_gap amended it by training balls of the same source. The oracle knows the physics "
        "that flew the ball. Off the racket, simulated balls fly on in their own hall's physics, "
        "measured ones in the literature's."
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
        "racket strikes well, fast or slow; the others are played all the same. turned: those that "
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
