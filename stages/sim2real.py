"""Sim-to-real: policies from an imperfect simulator play replayed measured shots."""

from rallygap.models.predictors.physics import PhysicsPredictor
from rallygap.pipeline.evaluation.predictors import NamedPredictor, read_learned
from rallygap.pipeline.io.amended_simulators import amended_by
from rallygap.pipeline.io.artifacts import write_json, write_table
from rallygap.pipeline.io.simulators import load_simulator
from rallygap.pipeline.runtime.stage_run import StageRun, run_stage
from rallygap.pipeline.transfer.example_returns import write_returns
from rallygap.pipeline.transfer.recorded_returns import example_returns
from rallygap.pipeline.transfer.replay_sets import ReplaySet, read_replay_sets
from rallygap.pipeline.transfer.replay_trials import (
    ONCE,
    Forecaster,
    Policies,
    ReplayTrial,
    informed_predictors,
    load_players,
    replay_trials,
    source_of,
)
from rallygap.pipeline.transfer.sim2real_report import report_sets, report_transfer
from rallygap.pipeline.transfer.tolerance import report_tolerance, tolerance_trials
from rallygap.pipeline.transfer.transfer_table import PHYSICS
from rallygap.pipeline.transfer.trials import joined, run_trials


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
    report_transfer(run, played, names)
    report_sets(run, sets)
    report_tolerance(run, joined(tolerated))


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


if __name__ == "__main__":
    run_stage(sim2real)
