"""Training and comparison of predictors in sweeps, on the data of the stage train_predictor."""

from collections.abc import Sequence
from functools import partial
from pathlib import Path

import lightning
import numpy as np
import pandas as pd
from lightning.pytorch.callbacks import Callback, LambdaCallback

from rallygap.models.predictors.errors import HORIZONS_MS, error_norms
from rallygap.models.predictors.evaluation import SHOWN_HORIZONS_MS
from rallygap.models.predictors.learned import LearnedPredictor
from rallygap.models.predictors.protocol import Floats
from rallygap.models.predictors.training import ForecastTraining, WindowData
from rallygap.pipeline.evaluation.evaluation_windows import MeasuredSet, read_test_sets
from rallygap.pipeline.params import Params
from rallygap.pipeline.predictors.trainer import train
from rallygap.pipeline.predictors.training_data import TrainingEpisodes, untrained_network
from rallygap.pipeline.runtime.parallel import parallel
from rallygap.pipeline.runtime.torch_threads import one_thread
from rallygap.pipeline.sweeps.comparison import SEEDS, comparison, repeat_seed
from rallygap.pipeline.sweeps.settings import PredictorSweep, Report
from rallygap.pipeline.tracking.live import live_run

UNITS = {"position": "mm", "velocity": "m/s", "spin": "rad/s"}
MEASURES = [
    f"position error, {HORIZONS_MS[0]} to {HORIZONS_MS[-1]} ms (mm)",
    *(f"{name} error at {ms} ms ({UNITS[name]})" for name in UNITS for ms in SHOWN_HORIZONS_MS),
]


class PredictorTraining:
    """Trains a network on the recordings of a repository and validates it as the stage does.

    Raises:
        InputError: there are no training or validation episodes.
    """

    def __init__(self, root: Path, sweep: PredictorSweep, params: Params) -> None:
        self.network, settings = sweep.network, params.train_predictor
        episodes = TrainingEpisodes(root / "artifacts", params.seed)
        data = episodes.window_data(settings.sources, settings.training)
        self.train, self.validation = data.train, data.validation

    def score(self, params: Params, folder: Path, report: Report) -> float:
        """Train; return the validation loss after the last epoch."""

        def validated(trainer: lightning.Trainer, _: lightning.LightningModule) -> None:
            report(trainer.current_epoch + 1, float(trainer.callback_metrics["validation"]))

        callback = LambdaCallback(on_validation_end=validated)
        return self.fit(params, folder, [callback]).curve[-1]["validation"]

    def fit(
        self, params: Params, folder: Path, callbacks: Sequence[Callback] = ()
    ) -> ForecastTraining:
        """Train the network, with checkpoints in a folder."""
        settings = params.train_predictor
        data = WindowData(self.train, self.validation, settings.training, params.seed)
        network = untrained_network(settings.networks[self.network], data)
        training = ForecastTraining(network, settings.training)
        train(training, data, folder, callbacks, live_run(self.network))
        return training


def compare_predictors(
    root: Path, sweep: PredictorSweep, settings: Sequence[Params], folder: Path
) -> pd.DataFrame:
    """Train the network with two parameter sets and every seed; compare its test errors.

    The repository ``root`` has the artefacts of ingest and segment; checkpoints go into ``folder``.
    """
    training, first = PredictorTraining(root, sweep, settings[0]), settings[0]
    every = first.evaluate_predictor.window_every_ms / 1000
    sets = [
        measured
        for measured in read_test_sets(root / "artifacts", every)
        if measured.name in first.train_predictor.sources
    ]
    tasks = [
        partial(_test_errors, training, seeded, folder / f"{number}-{repeat}", sets)
        for number, params in enumerate(settings)
        for repeat in range(SEEDS)
        for seeded in [params.model_copy(update={"seed": repeat_seed(params.seed, repeat + 1)})]
    ]
    errors = np.stack(list(parallel(tasks)))
    groups = np.tile(np.concatenate([measured.recordings for measured in sets]), (SEEDS, 1))
    return comparison(MEASURES, True, errors, groups, first.seed)


@one_thread()
def _test_errors(
    training: PredictorTraining, params: Params, folder: Path, sets: Sequence[MeasuredSet]
) -> Floats:
    """Train a predictor and return its (N, K) errors on test windows, K as in ``MEASURES``."""
    predictor = LearnedPredictor(training.fit(params, folder).network)
    shown = [HORIZONS_MS.index(horizon) for horizon in SHOWN_HORIZONS_MS]
    errors = []
    for windows in (measured.windows for measured in sets):
        forecast = predictor.predict(windows.history)
        by_quantity = [error_norms(forecast, windows, quantity) for quantity in UNITS]
        position = np.ma.masked_invalid(by_quantity[0]).mean(axis=1).filled(np.nan)
        errors.append(np.column_stack([position, *(error[:, shown] for error in by_quantity)]))
    return np.concatenate(errors)
