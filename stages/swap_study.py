"""When swapping the predictor helps; two hours on two cores.

Policies of the profile ``policies`` (two kinds of observations, two triples of horizons, three
trainings each) play the replayed shots of the arena: with all predictors under both readings of
the paper's Table I; and with four of them in all settings of the mechanism. Those with intercept
features are also trained in the amended simulator.
"""

from collections.abc import Callable, Iterable
from functools import partial
from pathlib import Path

import pandas as pd

from rallygap.models.predictors.physics import PhysicsPredictor
from rallygap.pipeline.evaluation.predictors import ARENA, read_trained
from rallygap.pipeline.experiments.profiles import profile_params
from rallygap.pipeline.experiments.swap_study.policies import amended_simulator, trained_policies
from rallygap.pipeline.experiments.swap_study.tables import EXPERIMENTS, PHYSICS, study_tables
from rallygap.pipeline.experiments.swap_study.trials import (
    Predictors,
    mechanism_trials,
    played,
    reading_trials,
)
from rallygap.pipeline.io.artifacts import read_table, write_table
from rallygap.pipeline.io.simulators import load_simulator
from rallygap.pipeline.params import Params
from rallygap.pipeline.policies.training import TrainingResult, play_test_shots, policies_table
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
    arena = [one for one in sets if source_of(one) == ARENA]
    if not arena:
        raise InputError("params.yaml", "names no arena to replay", field="ingest.sources")
    tasks: dict[str, dict[Path, Callable[[], None]]] = {name: {} for name in EXPERIMENTS}
    for shots in arena:
        trials = _trials(shots, _predictors(root, params, shots), trained, params)
        for experiment, found in trials.items():
            for number, (columns, trial) in enumerate(found):
                path = scratch / experiment / f"{shots.name}-{number}.parquet"
                tasks[experiment][path] = partial(_write, path, trial, columns)
    for experiment, some in tasks.items():
        make_missing(some, experiment)
    return {
        experiment: pd.concat([read_table(path) for path in some], ignore_index=True)
        for experiment, some in tasks.items()
    }


Trials = Iterable[tuple[dict[str, str | float], ReplayTrial]]


def _trials(
    shots: ReplaySet, predictors: Predictors, trained: list[TrainingResult], params: Params
) -> dict[str, Trials]:
    """Return the trials of a set with their columns in tables, by experiment."""
    own = params.sim2real.simulator
    original, again = (
        [
            (one.policy, one.description)
            for one in trained
            if (one.description.simulator == own) is it
        ]
        for it in (True, False)
    )
    seed = params.seed
    every_step = [Forecaster(*named) for named in predictors.items()]
    plain: dict[str, str | float] = {}
    return {
        "readings": [(plain, one) for one in reading_trials(shots, predictors, original, seed)],
        "mechanism": [
            (setting.columns, one)
            for setting, one in mechanism_trials(shots, predictors, original, seed)
        ],
        "retrained": [(plain, one) for one in replay_trials(shots, every_step, again, seed)],
    }


def _predictors(root: Path, params: Params, shots: ReplaySet) -> Predictors:
    """Return all predictors of a set of the arena."""
    learned = list(read_trained(root / "artifacts" / "train_predictor"))
    plain = {PHYSICS: params.sim2real.simulator, "physics_literature": "literature"}
    physics = {name: PhysicsPredictor(load_simulator(one)) for name, one in plain.items()}
    return {**physics, **informed_predictors(shots, learned, amended_simulator(root, params))}


def _write(path: Path, trial: ReplayTrial, columns: dict[str, str | float]) -> None:
    write_table(path, played(trial, columns))


if __name__ == "__main__":
    run_stage(swap_study)
