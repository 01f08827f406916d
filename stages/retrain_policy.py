"""Retrain the policies of sim2real in amended simulators, and replay the same shots to them."""

from collections.abc import Mapping, Sequence
from typing import Any

import pandas as pd

from rallygap.models.ball.simulator import Simulator
from rallygap.pipeline.evaluation.predictors import ARENA, read_learned
from rallygap.pipeline.io.amended_simulators import amended_by, verdict_path
from rallygap.pipeline.io.artifacts import read_as, read_table, write_table
from rallygap.pipeline.io.ground_truth import read_truth
from rallygap.pipeline.io.metrics import rounded
from rallygap.pipeline.io.simulators import load_simulator
from rallygap.pipeline.params import Sim2RealSettings
from rallygap.pipeline.policies.storage import save_policy
from rallygap.pipeline.policies.training import (
    TEST_TRIALS,
    TrainingJob,
    TrainingResult,
    play_test_shots,
    train_policies,
    trained_models,
)
from rallygap.pipeline.runtime.errors import InputError
from rallygap.pipeline.runtime.stage_run import StageRun, run_stage
from rallygap.pipeline.transfer.rates import rates
from rallygap.pipeline.transfer.replay_sets import read_replay_sets
from rallygap.pipeline.transfer.replay_trials import (
    Forecaster,
    Policies,
    informed_predictors,
    load_players,
    replay_trials,
    source_of,
)
from rallygap.pipeline.transfer.retraining import (
    ORIGINAL,
    RETRAINED,
    amended_name,
    in_simulator,
    pooled,
    retraining_table,
)
from rallygap.pipeline.transfer.returns import EVERY_STEP
from rallygap.pipeline.transfer.trials import joined, run_trials
from rallygap.pipeline.transfer.truth_comparison import NamedCauses, number_table


def retrain_policy(run: StageRun) -> None:
    """Retrain the policies of sim2real; compare them with the original ones on the same shots."""
    settings = read_as(run.input("sim2real", "settings.json"), Sim2RealSettings, "sim2real")
    sources = run.params.retrain_policy.sources
    simulators = {source: _amended(run, source, settings.simulator) for source in sources}
    originals = load_players(run.input("train_policy", ""), settings)
    results = _train(run, originals, simulators)
    replayed = _replay(run, settings, simulators, results)
    write_table(run.artifact("played.parquet"), pd.concat(replayed.values(), ignore_index=True))
    own = rates(_in_own_simulator(run, settings, results), ["simulator", "horizons_ms"])
    before = own[own["simulator"] == settings.simulator].set_index("horizons_ms")["return_rate"]
    tables = [
        retraining_table(pooled(table, source), before.to_dict())
        for source, table in replayed.items()
    ]
    returns = pd.concat(tables, ignore_index=True)
    numbers = _numbers(run, settings.simulator, simulators)
    run.keep(returns=returns, own_simulator=own, numbers=numbers)
    run.write_metrics(_metrics(returns[returns["set"].isin(sources)]))


def _numbers(run: StageRun, nominal: str, simulators: Mapping[str, Simulator]) -> pd.DataFrame:
    """Return the parameters of the nominal, the amended and the true simulator, by source."""
    truth = read_truth(run.input("ingest", "truth.json"))
    tables = {}
    for source, amended in simulators.items():
        path = verdict_path(run.input("close_gap", ""), source, nominal)
        causes = read_as(path, NamedCauses, "close_gap").causes
        known = truth.simulator if truth is not None and source == ARENA else None
        tables[source] = number_table(load_simulator(nominal), amended, causes, known)
    return pd.concat(tables, names=["source"]).reset_index("source")


def _metrics(returns: pd.DataFrame) -> dict[str, Any]:
    """Return ``{policy: return rate}``, means over sources, horizons and predictors."""
    means = returns.groupby("policy", sort=False)["return_rate"].mean()
    return {str(policy): {"return_rate": rounded(rate)} for policy, rate in means.items()}


def _amended(run: StageRun, source: str, nominal: str) -> Simulator:
    simulator = amended_by(run.input("close_gap", ""), source, nominal)
    if simulator is None:
        problem = f"close_gap has not amended {nominal} from shots of {source}"
        raise InputError("params.yaml", problem, field="retrain_policy.sources")
    return simulator


def _train(
    run: StageRun, originals: Policies, simulators: Mapping[str, Simulator]
) -> list[TrainingResult]:
    """Train every policy again in every amended simulator."""
    descriptions = [
        in_simulator(trained, source, simulator)
        for source, simulator in simulators.items()
        for _, trained in originals
    ]
    results = train_policies(
        [TrainingJob(description, run.scratch(description.name)) for description in descriptions]
    )
    for result in results:
        name = result.description.name
        save_policy(run.artifact(name), result.policy, result.description)
        run.timings[name] = {"training_cpu_s": round(result.seconds, 1)}
    return results


def _in_own_simulator(
    run: StageRun, settings: Sim2RealSettings, results: Sequence[TrainingResult]
) -> pd.DataFrame:
    """Return test trials in the policies' own simulators, as many for every policy."""
    known = read_table(run.input("train_policy", TEST_TRIALS))
    known = known[(known["group"] == settings.group) & (known["simulator"] == settings.simulator)]
    tests = play_test_shots(results, int(known["ball"].max()) + 1)
    run.models = trained_models(results, tests, run.artifact("."))
    return pd.concat([known, *(test.table for test in tests)], ignore_index=True)


def _replay(
    run: StageRun,
    settings: Sim2RealSettings,
    simulators: Mapping[str, Simulator],
    results: Sequence[TrainingResult],
) -> dict[str, pd.DataFrame]:
    """Return the trials of original and retrained policies, by source."""
    known = read_table(run.input("sim2real", "played.parquet"))
    known = known[known["protocol"] == EVERY_STEP].assign(policy=ORIGINAL)
    sets = read_replay_sets(run.root / "artifacts", settings, run.seed)
    learned = read_learned(run.input("train_predictor", ""), settings.learned)
    replayed = {}
    for source, simulator in simulators.items():
        own = [shots for shots in sets if source_of(shots) == source]
        if not own:
            problem = f"no shot of {source} can be replayed; see reports/sim2real/replayed.csv"
            raise InputError("params.yaml", problem, field="retrain_policy.sources")
        retrained = [
            (result.policy, result.description)
            for result in results
            if result.description.simulator == amended_name(source)
        ]
        trials = []
        for shots in own:
            informed = informed_predictors(shots, learned, simulator)
            forecasters = [Forecaster(*named) for named in informed.items()]
            trials += replay_trials(shots, forecasters, retrained, run.seed)
        before = known[known["set"].isin([shots.name for shots in own])]
        after = joined(run_trials([trial.run for trial in trials])).assign(policy=RETRAINED)
        replayed[source] = pd.concat([before, after], ignore_index=True)
    return replayed


if __name__ == "__main__":
    run_stage(retrain_policy)
