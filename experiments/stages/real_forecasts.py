"""Forecasts of measured sets, by cross-validation over recordings; half an hour on two cores.

Every recording is tested once, by predictors that the other folds adapted: the literature's
simulator amended, a hybrid that corrects this one, and transformers, both trained on the arena and
fine-tuned. Needs the measured sets in RALLYGAP_DATA.
"""

from collections.abc import Mapping
from functools import partial
from pathlib import Path

import numpy as np
import pandas as pd

from experiments.ensemble import EnsemblePredictor
from experiments.folds import fold_numbers
from experiments.real_forecasts import (
    HYBRID,
    OTHER,
    TRANSFORMER,
    FineTuning,
    Fold,
    Tested,
    amended_by,
)
from experiments.resumed import amended_simulators
from rallygap.models.ball.simulator import Simulator
from rallygap.models.predictors.evaluation import SHOWN_HORIZONS_MS, concat_tables
from rallygap.models.predictors.learned import LearnedPredictor
from rallygap.models.predictors.physics import PhysicsPredictor
from rallygap.models.predictors.protocol import ProbabilisticPredictor
from rallygap.pipeline.gap.expected_balls import expected_balls
from rallygap.pipeline.gap.measured_shots import read_recordings
from rallygap.pipeline.gap.shots import shots_of, source_shots
from rallygap.pipeline.io.simulators import load_simulator
from rallygap.pipeline.params import EvaluatePredictorSettings, Params
from rallygap.pipeline.predictors.parallel_training import TrainingResult, train_networks
from rallygap.pipeline.predictors.storage import load_network
from rallygap.pipeline.runtime.paths import measured_sets
from rallygap.pipeline.runtime.stage_run import StageRun, run_stage

SETS, FOLDS = ("spindoe", "tt3d", "isr_ball_prediction"), 5
NOMINAL, AMENDED = "literature", "amended"
NETWORKS = "artifacts/train_predictor"
Predictors = Mapping[str, ProbabilisticPredictor]  # by name
ENSEMBLES = {"transformer_ensemble": (TRANSFORMER, OTHER), "hybrid_ensemble": (HYBRID, TRANSFORMER)}
COMPARED = (HYBRID, "hybrid_ensemble")  # with all others, window by window


def real_forecasts(run: StageRun) -> None:
    """Write errors, paired differences and the coverage of regions.

    Raises:
        InputError: a set or a trained network cannot be read.
    """
    folder = measured_sets()
    folds = {name: _folds(folder / name, name) for name in SETS}
    settings = run.params.evaluate_predictor
    every = settings.window_every_ms / 1000
    every_fold = [fold for members in folds.values() for fold in members]
    adapted = _adapted(every_fold, run.root, run.params, run.scratch("adapted"))
    tested = {name: Tested.of(members, adapted, every) for name, members in folds.items()}
    run.publish(_tables(tested, settings, run.seed))


def _tables(
    tested: Mapping[str, Tested], settings: EvaluatePredictorSettings, seed: int
) -> dict[str, pd.DataFrame]:
    """Return the tables by the names of their files, at the horizons that are shown."""
    results = {name: test.errors(settings, seed) for name, test in tested.items()}
    tables = {
        "errors": {(name,): result.over_horizon() for name, result in results.items()},
        "differences": {
            (name,): result.differences(list(COMPARED)) for name, result in results.items()
        },
        "coverage": {(name,): test.coverage(settings, seed) for name, test in tested.items()},
    }
    return {name: _shown(parts) for name, parts in tables.items()}


def _shown(parts: Mapping[tuple[str], pd.DataFrame]) -> pd.DataFrame:
    """Return the tables of all sets as one, at the horizons that are shown."""
    rows = concat_tables(parts, ["set"])
    return rows[rows["horizon_ms"].isin(SHOWN_HORIZONS_MS)]


def _folds(folder: Path, name: str) -> list[Fold]:
    episodes = read_recordings(folder, name).episodes()
    recordings = np.array([episode.recording_id for episode in episodes])
    parts = list(zip(episodes, fold_numbers(name, recordings, FOLDS), strict=True))
    return [
        Fold(
            f"{name}-{number}",
            [episode for episode, part in parts if part == number],
            [episode for episode, part in parts if part != number],
        )
        for number in range(FOLDS)
    ]


def _adapted(folds: list[Fold], root: Path, params: Params, scratch: Path) -> dict[str, Predictors]:
    """Return all predictors for the test of each fold, by its name."""
    nominal = load_simulator(NOMINAL)
    amend = {fold.name: partial(amended_by, fold.others, nominal) for fold in folds}
    simulators = amended_simulators(amend, scratch)
    physics = {fold.name: _physics(fold, simulators[fold.name]) for fold in folds}
    trained = _fine_tuned(folds, physics, root, params, scratch)
    return {
        fold.name: {
            f"physics_{NOMINAL}": PhysicsPredictor(nominal),
            AMENDED: physics[fold.name],
            **_learned(
                {key: trained[f"{key}-{fold.name}"] for key in (HYBRID, TRANSFORMER, OTHER)}
            ),
        }
        for fold in folds
    }


def _learned(trained: Predictors) -> Predictors:
    """Return the learned predictors that are tested, and ensembles of them."""
    ensembles = {
        name: EnsemblePredictor([trained[member] for member in members])
        for name, members in ENSEMBLES.items()
    }
    return {HYBRID: trained[HYBRID], TRANSFORMER: trained[TRANSFORMER], **ensembles}


def _physics(fold: Fold, simulator: Simulator) -> PhysicsPredictor:
    """Return an amended simulator that expects such balls as the other folds have."""
    shots = shots_of(source_shots(fold.others).members)
    return PhysicsPredictor(simulator, expected_balls(shots, simulator))


def _fine_tuned(
    folds: list[Fold],
    physics: Mapping[str, PhysicsPredictor],
    root: Path,
    params: Params,
    scratch: Path,
) -> Predictors:
    settings = params.train_predictor
    folder = root / NETWORKS
    tuning = FineTuning(
        load_network(folder / TRANSFORMER),
        load_network(folder / HYBRID),
        settings.training.model_copy(update=settings.fine_tuning.model_dump(exclude={"sources"})),
        params.seed,
    )
    jobs = [job for fold in folds for job in tuning.jobs(fold, physics[fold.name], scratch)]
    results: list[TrainingResult] = train_networks(jobs)
    return {result.name: LearnedPredictor(result.network, result.spread) for result in results}


if __name__ == "__main__":
    run_stage(real_forecasts)
