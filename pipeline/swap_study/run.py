"""The experiment ``make swap-study``: hours on two cores, after ``make reproduce``.

Policies of the profile ``policies`` (two kinds of observations, two triples of horizons, three
trainings each) play the replayed shots of the arena: with all predictors under both readings of
the paper's Table I; and with four of them in all settings of the mechanism. A killed run resumes.
"""

import shutil
from collections.abc import Callable
from functools import partial
from pathlib import Path

import pandas as pd

from models.predictors.physics import PhysicsPredictor
from pipeline.evaluation.costs import machine
from pipeline.evaluation.predictors import ARENA, read_trained
from pipeline.experiments.profiles import merged
from pipeline.io.amended_simulators import amended_by
from pipeline.io.artifacts import read_table, write_csv, write_json, write_table
from pipeline.io.figure_style import apply_style, save_figure
from pipeline.io.simulators import load_simulator
from pipeline.params import Params, check_params, read_yaml
from pipeline.policies.descriptions import described_policies
from pipeline.policies.training import (
    TrainingJob,
    TrainingResult,
    play_test_shots,
    train_policies,
)
from pipeline.runtime.console import refuse
from pipeline.runtime.errors import InputError
from pipeline.runtime.parallel import make_missing
from pipeline.runtime.paths import repository_root
from pipeline.runtime.provenance import combined_hash, short
from pipeline.swap_study.comparisons import differences, rates
from pipeline.swap_study.figures import mechanism_figure, readings_figure
from pipeline.swap_study.trials import (
    Predictors,
    mechanism_trials,
    played,
    reading_trials,
)
from pipeline.transfer.replay_sets import ReplaySet, read_replay_sets
from pipeline.transfer.replay_trials import ReplayTrial, informed_predictors, source_of

REPORT = Path("reports") / "swap_study"
SCRATCH = Path("scratch") / "swap_study"
PROFILE = Path("profiles") / "policies.yaml"
PHYSICS = "physics_c"  # what others are compared with
POLICY, MECHANISM = ["observation", "horizons_ms"], ["age_ms", "latency_ms", "label_error"]
# What trainings and trials depend on.
DEPENDENCIES = ("models", "pipeline/transfer", "params.yaml", "profiles", "artifacts/segment")


def swap_study(root: Path) -> None:
    """Write rates, differences and figures to ``reports/swap_study``.

    Raises:
        InputError: the stages before have not run.
    """
    params = check_params(merged(read_yaml(root / "params.yaml"), read_yaml(root / PROFILE)), root)
    scratch = root / SCRATCH / short(combined_hash(root, DEPENDENCIES))
    described = described_policies(params.train_policy.groups, params.seed)
    jobs = [TrainingJob(one, scratch / "policies" / one.name) for one in described]
    trained = train_policies(jobs)
    folder = root / REPORT
    write_csv(folder / "policies.csv", _own_simulator(params, trained), digits=4)
    readings, mechanism = _played(root, params, trained, scratch)
    tables = {
        "readings": rates(readings, ["set", *POLICY, "predictor", "protocol"], params.seed),
        "readings_all": rates(readings, [*POLICY, "predictor", "protocol"], params.seed),
        "mechanism": rates(mechanism, [*POLICY, "predictor", *MECHANISM], params.seed),
        "gains": differences(readings, [*POLICY, "protocol"], "predictor", PHYSICS, params.seed),
        "gains_by_set": differences(
            readings, ["set", *POLICY, "protocol"], "predictor", PHYSICS, params.seed
        ),
        "gains_every_tick": differences(
            readings, [*POLICY, "predictor"], "protocol", "first_window", params.seed
        ),
        "gains_mechanism": differences(
            mechanism, [*POLICY, *MECHANISM], "predictor", PHYSICS, params.seed
        ),
    }
    for name, table in tables.items():
        write_csv(folder / f"{name}.csv", table, digits=4)
    apply_style()
    save_figure(folder / "readings.png", readings_figure(tables["readings_all"]))
    save_figure(folder / "mechanism.png", mechanism_figure(tables["gains_mechanism"]))
    write_json(folder / "run.json", machine(root))
    shutil.rmtree(root / SCRATCH)


def _own_simulator(params: Params, trained: list[TrainingResult]) -> pd.DataFrame:
    """Return how policies play test shots of their own simulator, one row each."""
    tests = play_test_shots(trained, params.train_policy.trials)
    rows = pd.concat([one.table for one in tests]).groupby(
        ["group", "horizons_ms", "repeat"], sort=False
    )
    means = rows[["hit", "returned"]].mean()
    seconds = [round(one.seconds) for one in trained]
    return means.reset_index().assign(training_cpu_s=seconds)


def _played(
    root: Path, params: Params, trained: list[TrainingResult], scratch: Path
) -> tuple[pd.DataFrame, pd.DataFrame]:
    """Return the trials of both readings, and those of the mechanism."""
    policies = [(one.policy, one.description) for one in trained]
    sets = read_replay_sets(root / "artifacts", params.sim2real, params.seed)
    arena = [one for one in sets if source_of(one) == ARENA]
    if not arena:
        raise InputError("params.yaml", "names no arena to replay", field="ingest.sources")
    tasks: dict[str, dict[Path, Callable[[], None]]] = {"readings": {}, "mechanism": {}}
    for shots in arena:
        predictors = _predictors(root, params, shots)
        for one in reading_trials(shots, predictors, policies, params.seed):
            name = f"{shots.name}-{one.forecaster.name}-{one.forecaster.protocol}"
            path = scratch / "readings" / f"{name}.parquet"
            tasks["readings"][path] = partial(_write, path, one, {})
        for number, (setting, one) in enumerate(
            mechanism_trials(shots, predictors, policies, params.seed)
        ):
            path = scratch / "mechanism" / f"{shots.name}-{number}.parquet"
            tasks["mechanism"][path] = partial(_write, path, one, setting.columns)
    for name, some in tasks.items():
        make_missing(some, name)
    readings, mechanism = (
        pd.concat([read_table(path) for path in some], ignore_index=True) for some in tasks.values()
    )
    return readings, mechanism


def _predictors(root: Path, params: Params, shots: ReplaySet) -> Predictors:
    """Return all predictors of a set of the arena."""
    simulator = params.sim2real.simulator
    amended = amended_by(root / "artifacts" / "close_gap", ARENA, simulator)
    learned = list(read_trained(root / "artifacts" / "train_predictor"))
    plain = {PHYSICS: simulator, "physics_literature": "literature"}
    physics = {name: PhysicsPredictor(load_simulator(one)) for name, one in plain.items()}
    return {**physics, **informed_predictors(shots, learned, amended)}


def _write(path: Path, trial: ReplayTrial, columns: dict[str, str | float]) -> None:
    write_table(path, played(trial, columns))


if __name__ == "__main__":
    try:
        swap_study(repository_root())
    except InputError as error:
        refuse(error)
