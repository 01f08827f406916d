"""Sim-to-real: policies from an imperfect simulator play replayed measured shots."""

from collections.abc import Sequence
from typing import Any

import pandas as pd

from rallygap.models.predictors.physics import PhysicsPredictor
from rallygap.pipeline.evaluation.predictors import NamedPredictor, read_learned
from rallygap.pipeline.io.amended_simulators import amended_by
from rallygap.pipeline.io.artifacts import write_json, write_table
from rallygap.pipeline.io.metrics import rounded
from rallygap.pipeline.io.simulators import load_simulator
from rallygap.pipeline.runtime.stage_run import StageRun, run_stage
from rallygap.pipeline.transfer.example_returns import example_returns
from rallygap.pipeline.transfer.rates import differences, rates
from rallygap.pipeline.transfer.replay_sets import ReplaySet, read_replay_sets
from rallygap.pipeline.transfer.replay_trials import (
    Forecaster,
    Policies,
    ReplayTrial,
    informed_predictors,
    load_players,
    replay_trials,
    source_of,
    tolerance_trials,
)
from rallygap.pipeline.transfer.returns import BASELINE, ONCE, PHYSICS, SETTING
from rallygap.pipeline.transfer.shown_returns import write_returns
from rallygap.pipeline.transfer.trials import joined, run_trials

FIRST_BASELINE = {"predictor": PHYSICS, "protocol": ONCE}
KEYS = [*SETTING, *BASELINE]  # of an experiment


def sim2real(run: StageRun) -> None:
    """Replay measured shots to policies with every predictor; then test forecast errors."""
    settings, folder = run.params.sim2real, run.input("train_policy", "")
    policies = load_players(folder, settings)
    run.log_input(f"policies of {settings.group}", folder, len(policies))
    sets = read_replay_sets(run.root / "artifacts", settings, run.seed)
    for shots in sets:
        run.log_input(shots.name, run.input("segment", "episodes.parquet"), len(shots))
    learned = read_learned(run.input("train_predictor", ""), settings.learned)
    names = [predictor.name for predictor in learned]
    trials = [trial for shots in sets for trial in _trials(run, shots, policies, learned)]
    results = run_trials([trial.run for trial in trials])
    played = joined(results)
    write_table(run.artifact("played.parquet"), played)
    pairs = list(zip(trials, results, strict=True))
    examples = [
        example
        for shots in sets
        for example in example_returns([pair for pair in pairs if pair[0].shots is shots], names)
    ]
    write_returns(run.artifact("returns.json"), examples)
    write_json(run.artifact("settings.json"), settings.model_dump(mode="json"))
    tolerated = run_trials(tolerance_trials(run, policies))
    table = _rates(played)
    run.keep(
        rates=table,
        differences=differences(played, SETTING, BASELINE),
        differences_first_window=differences(played, SETTING, FIRST_BASELINE),
        replayed=_replayed(sets),
        tolerance=rates(joined(tolerated), ["error", "size_cm", "horizons_ms"]),
    )
    run.write_metrics(_metrics(table))


def _trials(
    run: StageRun, shots: ReplaySet, policies: Policies, learned: list[NamedPredictor]
) -> list[ReplayTrial]:
    """Return the trials of a set: with physics, and with the predictors that know more."""
    simulator = run.params.sim2real.simulator
    physics = PhysicsPredictor(load_simulator(simulator))
    amended = amended_by(run.input("close_gap", ""), source_of(shots), simulator)
    informed = informed_predictors(shots, learned, amended)
    forecasters = [
        Forecaster(PHYSICS, physics, ONCE),
        *(Forecaster(*named) for named in {PHYSICS: physics, **informed}.items()),
    ]
    recorded = [PHYSICS, *(predictor.name for predictor in learned)]
    return replay_trials(shots, forecasters, policies, run.seed, recorded)


def _rates(played: pd.DataFrame) -> pd.DataFrame:
    """Return ``rates`` with the forecast errors."""
    table = rates(played, KEYS)
    errors = played.groupby(KEYS, sort=False)["forecast_error_m"].mean()
    return table.assign(forecast_error_cm=100 * errors.to_numpy())


def _replayed(sets: Sequence[ReplaySet]) -> pd.DataFrame:
    """Return the numbers of replayed and excluded shots, one row a set."""
    rows = [
        {
            "set": shots.name,
            "replayed": len(shots),
            "in_reach": shots.in_reach,
            "rotated": shots.rotated,
            "excluded": ", ".join(f"{count} {why}" for why, count in shots.excluded.items())
            or None,
            "spin": shots.spin,
            "physics": "true" if shots.oracle else "literature",
        }
        for shots in sets
    ]
    return pd.DataFrame(rows)


def _metrics(table: pd.DataFrame) -> dict[str, Any]:
    """Return ``{predictor: return rate}``, means over sets, horizons and protocols."""
    means = table.groupby("predictor", sort=False)["return_rate"].mean()
    return {str(name): {"return_rate": rounded(rate)} for name, rate in means.items()}


if __name__ == "__main__":
    run_stage(sim2real)
