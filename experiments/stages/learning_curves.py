"""Errors of predictors by the number of training recordings; 1.5 hours on two cores.

Simulators are amended, and networks trained, by more and more of the arena's training recordings,
in three random orders. All forecast the same test windows.
"""

from collections.abc import Iterator, Mapping
from functools import partial
from pathlib import Path

import numpy as np

from experiments.learning_curves import Errors, Learner, Subset, curve_rows, subsets
from experiments.resumed import amended_simulators
from rallygap.models.predictors.errors import HORIZONS_MS, error_norms
from rallygap.models.predictors.evaluation import SHOWN_HORIZONS_MS
from rallygap.models.predictors.learned import LearnedPredictor
from rallygap.models.predictors.physics import PhysicsPredictor
from rallygap.models.predictors.protocol import ProbabilisticPredictor
from rallygap.pipeline.evaluation.evaluation_windows import MeasuredSet, read_test_sets
from rallygap.pipeline.evaluation.forecasts import forecast_windows
from rallygap.pipeline.evaluation.predictors import ARENA, ORACLE, NamedPredictor
from rallygap.pipeline.io.amended_simulators import AMENDED
from rallygap.pipeline.io.ground_truth import read_truth
from rallygap.pipeline.predictors.parallel_training import train_networks
from rallygap.pipeline.runtime.errors import InputError
from rallygap.pipeline.runtime.stage_run import StageRun, run_stage

SIZES, DRAWS = (10, 30, 100, 300, 1000), 3
BASE, NETWORKS = "imperfect_c", ("hybrid", "transformer")


def learning_curves(run: StageRun) -> None:
    """Write the learning curves.

    Raises:
        InputError: the stages before have not run, or not with the arena.
    """
    every = run.params.evaluate_predictor.window_every_ms / 1000
    (test,) = (test for test in read_test_sets(run.root / "artifacts", every) if test.name == ARENA)
    errors = list(_all_errors(run, test))
    run.publish({"errors": curve_rows(errors, test.recordings, list(SHOWN_HORIZONS_MS))})


def _all_errors(run: StageRun, test: MeasuredSet) -> Iterator[Errors]:
    """Yield the errors of all kinds of predictors."""
    learner, scratch = Learner(run.root / "artifacts", ARENA, run.params), run.scratch("learned")
    chosen = list(subsets(learner.recordings, SIZES, DRAWS, run.seed))
    yield from _errors(test, chosen, f"{AMENDED}_{BASE}", _amended(learner, chosen, scratch))
    for network in NETWORKS:
        yield from _errors(test, chosen, network, _trained(learner, chosen, network, scratch))
    yield from _errors(test, chosen, ORACLE, _oracle(run, chosen))


Predictors = Mapping[str, ProbabilisticPredictor]  # by the name of the subset


def _errors(
    test: MeasuredSet, chosen: list[Subset], name: str, predictors: Predictors
) -> Iterator[Errors]:
    """Yield the errors of a kind of predictor, for each number of recordings."""
    shown = [HORIZONS_MS.index(horizon) for horizon in SHOWN_HORIZONS_MS]
    named = [NamedPredictor(key, predictor, name) for key, predictor in predictors.items()]
    forecasts = forecast_windows(test, named)
    for size in sorted({subset.size for subset in chosen}):
        of_size = [forecasts[subset.name] for subset in chosen if subset.size == size]
        norms = [error_norms(forecast, test.windows, "position")[:, shown] for forecast in of_size]
        yield Errors(name, size, np.stack(norms) / 1e3)


def _amended(learner: Learner, chosen: list[Subset], scratch: Path) -> Predictors:
    amend = {subset.name: partial(learner.amended, subset, BASE) for subset in chosen}
    return {
        name: PhysicsPredictor(simulator)
        for name, simulator in amended_simulators(amend, scratch).items()
    }


def _trained(learner: Learner, chosen: list[Subset], network: str, scratch: Path) -> Predictors:
    jobs = [
        learner.training(subset, network, scratch / f"{network}-{subset.name}") for subset in chosen
    ]
    results = train_networks(jobs)
    return {
        subset.name: LearnedPredictor(result.network, result.spread)
        for subset, result in zip(chosen, results, strict=True)
    }


def _oracle(run: StageRun, chosen: list[Subset]) -> Predictors:
    path = run.input("ingest", "truth.json")
    truth = read_truth(path)
    if truth is None:
        raise InputError(path, "is missing; run `dvc repro ingest` with the arena")
    return dict.fromkeys((subset.name for subset in chosen), PhysicsPredictor(truth.simulator))


if __name__ == "__main__":
    run_stage(learning_curves)
