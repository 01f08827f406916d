"""What a sweep of predictors trains and tests: one network, on the stage's own balls."""

from collections.abc import Sequence
from pathlib import Path
from typing import Any

import lightning
from lightning.pytorch.callbacks import Callback

from models.predictors.learned import ForecastNetwork, build_network
from models.predictors.training import ForecastTraining, WindowData
from models.predictors.window_dataset import Tracks, tracks
from pipeline.io.episodes import read_episodes
from pipeline.params import Params
from pipeline.predictors.trainer import train
from pipeline.runtime.errors import InputError
from pipeline.sources.manifest import read_manifest
from pipeline.sweeps.settings import PredictorSweep
from pipeline.sweeps.trial_types import Watch


class PredictorTrials:
    """Trains a network on training balls and scores it on those for validation.

    Args:
        root: of the repository, with the artefacts of ingest and segment.
        sweep: which network.
        params: on whose sources.

    Raises:
        InputError: there is nothing to learn from.
    """

    def __init__(self, root: Path, sweep: PredictorSweep, params: Params) -> None:
        self.network = sweep.network
        self.train, self.validation = _splits(root / "artifacts", params.train_predictor.sources)

    def score(self, params: Params, folder: Path, watch: Watch) -> float:
        """Return the validation loss after the last epoch."""
        training = self.trained(params, folder, [_Watching(watch)])
        return training.curve[-1]["validation"]

    def trained(
        self, params: Params, folder: Path, watchers: Sequence[Callback] = ()
    ) -> ForecastTraining:
        """Train the network as the stage does; ``watchers`` see every epoch."""
        settings = params.train_predictor
        lightning.seed_everything(params.seed, verbose=False)
        network: ForecastNetwork = build_network(settings.networks[self.network])
        data = WindowData(self.train, self.validation, settings.training, params.seed)
        data.fit_normaliser(network)
        training = ForecastTraining(network, settings.training)
        train(training, data, folder, watchers)
        return training


class _Watching(Callback):
    """Tells the validation loss of every epoch."""

    def __init__(self, watch: Watch) -> None:
        self.watch = watch

    def on_validation_end(self, trainer: lightning.Trainer, *_: Any) -> None:
        """Tell it, and let a trial that lags behind end here."""
        self.watch(trainer.current_epoch + 1, float(trainer.callback_metrics["validation"]))


def _splits(artifacts: Path, sources: Sequence[str]) -> tuple[Tracks, Tracks]:
    """Return the tracks of the balls for training and for validation."""
    manifest = read_manifest(artifacts / "ingest" / "manifest.json")
    splits = ("train", "validation")
    episodes = read_episodes(artifacts / "segment", manifest.labelled_once, splits)
    usable = [one for one in episodes if one.unbroken and one.source in sources]
    try:
        training, validation = (
            tracks([one.episode for one in usable if one.split == split]) for split in splits
        )
    except ValueError as error:
        path = artifacts / "segment" / "episodes.parquet"
        raise InputError(path, f"{error}: {', '.join(sources)}") from None
    return training, validation
