"""When swapping the predictor helps; two hours on two cores.

Policies of the profile ``policies`` (two kinds of observations, two triples of horizons, three
trainings each) play the replayed shots of the arena: with all predictors under both readings of
the paper's Table I; and with four of them in all settings of the mechanism. Those with intercept
features are also trained in the amended simulator.
"""

from functools import partial
from pathlib import Path

import pandas as pd

from experiments.swap_study import (
    EXPERIMENTS,
    PHYSICS,
    Predictors,
    amended_simulator,
    mechanism_trials,
    played,
    reading_trials,
    study_tables,
    trained_policies,
)
from rallygap.models.predictors.physics import PhysicsPredictor
from rallygap.pipeline.evaluation.predictors import ARENA, read_trained
from rallygap.pipeline.io.artifacts import read_table, write_table
from rallygap.pipeline.io.simulators import load_simulator
from rallygap.pipeline.params import Params
from rallygap.pipeline.policies.training import TrainingResult, play_test_shots, policies_table
from rallygap.pipeline.profiles import profile_params
from rallygap.pipeline.runtime.errors import InputError
from rallygap.pipeline.runtime.parallel import make_missing
from rallygap.pipeline.runtime.stage_run import StageRun, run_stage
from rallygap.pipeline.transfer.replay_sets import ReplaySet, read_replay_sets
from rallygap.pipeline.transfer.replay_trials import (
    Forecaster,
    ReplayTrial,
    informed_predictors,
    replay_trials,
    source_of,
)

PROFILE = "policies"


def swap_study(run: StageRun) -> None:
    """Write rates and differences.

    Raises:
        InputError: the arena is not replayed, or no simulator was amended from its shots.
    """
    params = profile_params(run.root, PROFILE)
    trained = trained_policies(run.root, params, run.scratch("policies"))
    tests = play_test_shots(trained, params.train_policy.trials)
    played = _played(run.root, params, trained, run.scratch("played"))
    run.publish({"policies": policies_table(trained, tests), **study_tables(played)})


def _played(
    root: Path, params: Params, trained: list[TrainingResult], scratch: Path
) -> dict[str, pd.DataFrame]:
    """Return the trials of all experiments on all sets of the arena."""
    sets = read_replay_sets(root / "artifacts", params.sim2real, params.seed)
    arena = [shots for shots in sets if source_of(shots) == ARENA]
    if not arena:
        raise InputError("params.yaml", "names no arena to replay", field="ingest.sources")
    by_set = {shots.name: _trials(root, shots, trained, params) for shots in arena}
    tables = {}
    for experiment in EXPERIMENTS:
        tasks = {}
        for name, trials in by_set.items():
            for number, trial in enumerate(trials[experiment]):
                path = scratch / experiment / f"{name}-{number}.parquet"
                tasks[path] = partial(_write, path, *trial)
        make_missing(tasks, experiment)
        tables[experiment] = pd.concat([read_table(path) for path in tasks], ignore_index=True)
    return tables


def _trials(
    root: Path, shots: ReplaySet, trained: list[TrainingResult], params: Params
) -> dict[str, list[tuple[ReplayTrial, dict[str, str | float]]]]:
    """Return the trials of a set with their columns in tables, by experiment."""
    own, seed, predictors = params.sim2real.simulator, params.seed, _predictors(root, params, shots)
    original, again = (
        [
            (result.policy, result.description)
            for result in trained
            if (result.description.simulator == own) is is_original
        ]
        for is_original in (True, False)
    )
    every_step = [Forecaster(*named) for named in predictors.items()]
    return {
        "readings": [(trial, {}) for trial in reading_trials(shots, predictors, original, seed)],
        "mechanism": [
            (trial, setting.columns)
            for setting, trial in mechanism_trials(shots, predictors, original, seed)
        ],
        "retrained": [(trial, {}) for trial in replay_trials(shots, every_step, again, seed)],
    }


def _predictors(root: Path, params: Params, shots: ReplaySet) -> Predictors:
    """Return all predictors of a set of the arena."""
    learned = list(read_trained(root / "artifacts" / "train_predictor"))
    plain = {PHYSICS: params.sim2real.simulator, "physics_literature": "literature"}
    physics = {
        name: PhysicsPredictor(load_simulator(simulator)) for name, simulator in plain.items()
    }
    return {**physics, **informed_predictors(shots, learned, amended_simulator(root, params))}


def _write(path: Path, trial: ReplayTrial, columns: dict[str, str | float]) -> None:
    write_table(path, played(trial, columns))


if __name__ == "__main__":
    run_stage(swap_study)
