"""Forecasts of measured sets, by cross-validation over recordings (``make real``; a quarter hour).

Every recording is tested once, by predictors that the other folds adapted: the literature's
simulator amended, and networks of the arena fine-tuned. Needs the trained networks of
`dvc repro train_predictor`. A killed run resumes.
"""

import hashlib
import os
import shutil
from collections.abc import Mapping
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from models.ball.simulator import Simulator
from models.predictors.evaluation import SHOWN_HORIZONS_MS, ForecastErrors, concat_tables
from models.predictors.evaluation import forecast_errors as errors_of
from models.predictors.learned import LearnedPredictor
from models.predictors.physics import PhysicsPredictor
from models.predictors.protocol import Forecast, Predictor
from models.predictors.windows import Windows, concatenate_windows, cut_windows
from pipeline.evaluation.costs import machine
from pipeline.evaluation.forecasts import concatenated
from pipeline.gap.amended_files import amended_simulators
from pipeline.gap.expected_balls import expected_balls
from pipeline.gap.folds import fold_numbers
from pipeline.gap.measured_shots import read_measured_episodes
from pipeline.gap.shots import shots_of, source_shots
from pipeline.io.artifacts import write_csv, write_json
from pipeline.io.episodes import MeasuredEpisode
from pipeline.io.simulators import load_simulator
from pipeline.params import Params, load_params
from pipeline.predictors.parallel_training import TrainingResult, train_networks
from pipeline.predictors.storage import load_network
from pipeline.real_forecasts.adapted import HYBRID, ON_AMENDED, TRANSFORMER, FineTuning, amended_by
from pipeline.runtime.console import refuse
from pipeline.runtime.errors import InputError
from pipeline.runtime.paths import repository_root
from pipeline.runtime.provenance import combined_hash, short

SETS, FOLDS = ("spindoe", "tt3d", "isr_ball_prediction"), 5
NOMINAL, AMENDED = "literature", "amended"
REPORT = Path("reports") / "real"
SCRATCH = Path("scratch") / "real_forecasts"
# What results depend on, besides the recordings.
DEPENDENCIES = ("models", "pipeline/real_forecasts", "params.yaml", "artifacts/train_predictor")
COMPARED = (AMENDED, HYBRID, ON_AMENDED)  # with all others, window by window


@dataclass(frozen=True)
class Fold:
    """One part of the recordings of a set, which the others adapt predictors for.

    Attributes:
        name: of its files.
        tested: its episodes.
        others: those of the other folds.
    """

    name: str
    tested: list[MeasuredEpisode]
    others: list[MeasuredEpisode]


def real_forecasts(root: Path, folder: Path) -> None:
    """Write errors and paired differences to ``reports/real``.

    Args:
        root: of the repository.
        folder: with a folder for each set.

    Raises:
        InputError: a set or a trained network cannot be read.
    """
    params = load_params(root / "params.yaml")
    folds = {name: _folds(folder / name, name) for name in SETS}
    scratch = root / SCRATCH / _fingerprint(root, folds)
    every = params.evaluate_predictor.window_every_ms / 1000
    adapted = _adapted([one for some in folds.values() for one in some], root, params, scratch)
    found = {name: _errors(some, adapted, every, params) for name, some in folds.items()}
    over = concat_tables({(name,): one.over_horizon() for name, one in found.items()}, ["set"])
    rows = over[over["horizon_ms"].isin(SHOWN_HORIZONS_MS)]
    write_csv(root / REPORT / "forecasts.csv", rows, digits=4)
    pairs = {(name,): one.differences(list(COMPARED)) for name, one in found.items()}
    write_csv(root / REPORT / "forecast_differences.csv", concat_tables(pairs, ["set"]), digits=4)
    write_json(root / REPORT / "forecasts.json", machine(root))
    shutil.rmtree(root / SCRATCH)


def _folds(folder: Path, name: str) -> list[Fold]:
    episodes = read_measured_episodes(folder, name)
    of_episodes = fold_numbers(name, _recordings(episodes), FOLDS)
    return [
        Fold(
            f"{name}-{number}",
            [one for one, k in zip(episodes, of_episodes, strict=True) if k == number],
            [one for one, k in zip(episodes, of_episodes, strict=True) if k != number],
        )
        for number in range(FOLDS)
    ]


def _adapted(
    folds: list[Fold], root: Path, params: Params, scratch: Path
) -> dict[str, dict[str, Predictor]]:
    """Return all predictors for the test of each fold, by its name."""
    nominal = load_simulator(NOMINAL)
    amend = {fold.name: partial(amended_by, fold.others, nominal) for fold in folds}
    simulators = amended_simulators(amend, scratch)
    physics = {fold.name: _physics(fold, simulators[fold.name]) for fold in folds}
    trained = _fine_tuned(folds, physics, root, params, scratch)
    keys = (TRANSFORMER, HYBRID, ON_AMENDED)
    return {
        fold.name: {
            f"physics_{NOMINAL}": PhysicsPredictor(nominal),
            AMENDED: physics[fold.name],
            **{key: trained[f"{key}-{fold.name}"] for key in keys},
        }
        for fold in folds
    }


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
) -> dict[str, Predictor]:
    settings = params.train_predictor
    folder = root / "artifacts" / "train_predictor"
    tuning = FineTuning(
        {name: load_network(folder / name) for name in (TRANSFORMER, HYBRID)},
        settings.training.model_copy(update=settings.fine_tuning.model_dump(exclude={"sources"})),
        params.seed,
    )
    jobs = [
        job
        for fold in folds
        for job in tuning.jobs(fold.others, physics[fold.name], fold.name, scratch)
    ]
    results: list[TrainingResult] = train_networks(jobs)
    return {one.name: LearnedPredictor(one.network, one.spread) for one in results}


def _errors(
    folds: list[Fold], adapted: Mapping[str, Mapping[str, Predictor]], every: float, params: Params
) -> ForecastErrors:
    """Return the errors on all recordings of a set."""
    windows: list[Windows] = []
    forecasts: dict[str, list[Forecast]] = {}
    recordings: list[NDArray[Any]] = []
    for fold in folds:
        members = [one for one in fold.tested if one.unbroken]
        parts = [cut_windows(one.episode, every) for one in members]
        windows.append(concatenate_windows(parts))
        recordings.append(np.repeat(_recordings(members), [len(part) for part in parts]))
        for name, predictor in adapted[fold.name].items():
            forecasts.setdefault(name, []).append(predictor.predict(windows[-1].history))
    whole = concatenate_windows(windows)
    return ForecastErrors(
        errors_of({name: concatenated(parts) for name, parts in forecasts.items()}, whole),
        np.concatenate(recordings),
        whole.bounced[:, -1],
        params.evaluate_predictor.bootstrap_resamples,
        params.seed,
    )


def _recordings(episodes: list[MeasuredEpisode]) -> NDArray[Any]:
    return np.array([one.recording_id for one in episodes])


def _fingerprint(root: Path, folds: Mapping[str, list[Fold]]) -> str:
    digest = hashlib.sha256(combined_hash(root, DEPENDENCIES).encode())
    for fold in (one for some in folds.values() for one in some):
        for episode in fold.tested:
            digest.update(episode.episode.positions.tobytes())
    return short(digest.hexdigest())


if __name__ == "__main__":
    try:
        real_forecasts(repository_root(), Path(os.environ.get("RALLYGAP_DATA", "")))
    except InputError as error:
        refuse(error)
