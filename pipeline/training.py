"""Runs Lightning for a stage: on what there is, quietly, and so that it can resume."""

import logging
import signal
import warnings
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import lightning
import torch
from lightning.pytorch.callbacks import Callback, ModelCheckpoint
from lightning.pytorch.utilities.exceptions import SIGTERMException

from models.predictors.settings import TrainingSettings
from models.predictors.training import ForecastTraining, WindowData


def train(
    training: ForecastTraining,
    data: WindowData,
    checkpoints: Path,
    watchers: Sequence[Callback] = (),
) -> None:
    """Train a network in place.

    Every epoch leaves a checkpoint, from which a run that was killed goes on; the result is that
    of an undisturbed run. After the last epoch there is nothing left to do.

    Args:
        training: the network and the recipe.
        data: the windows.
        checkpoints: a folder that belongs to this training alone.
        watchers: callbacks beside those that training needs.

    Raises:
        SystemExit: the process was told to stop (SIGTERM).
    """
    torch.set_num_threads(training.settings.threads)
    last = checkpoints / "last.ckpt"
    resumed = last if last.exists() else None
    with _quiet():
        trainer = _trainer(training.settings, checkpoints, watchers)
        try:
            trainer.fit(training, data, ckpt_path=resumed, weights_only=False)
        except SIGTERMException:
            # Lightning's would end the process with status 0, as if all were done.
            raise SystemExit(128 + signal.SIGTERM) from None


def _trainer(
    settings: TrainingSettings, checkpoints: Path, watchers: Sequence[Callback]
) -> lightning.Trainer:
    return lightning.Trainer(
        max_epochs=settings.epochs,
        precision=settings.precision,
        gradient_clip_val=settings.longest_gradient,
        deterministic=True,
        # Batches depend on the number of the epoch.
        reload_dataloaders_every_n_epochs=1,
        callbacks=[_saved_every_epoch(checkpoints), *watchers],
        default_root_dir=checkpoints,
        logger=False,
        enable_progress_bar=False,
        enable_model_summary=False,
        num_sanity_val_steps=0,
    )


@contextmanager
def _quiet() -> Iterator[None]:
    """Leave out Lightning's advice and advertisements."""
    logging.getLogger("lightning.pytorch").setLevel(logging.ERROR)
    with warnings.catch_warnings():
        warnings.filterwarnings("ignore", module=r"lightning\.")
        yield


def _saved_every_epoch(folder: Path) -> ModelCheckpoint:
    return ModelCheckpoint(
        dirpath=folder,
        filename="last",
        enable_version_counter=False,
        save_on_train_epoch_end=True,
    )


class Steps(Callback):
    """Tells how many steps are done, at the start and after each."""

    def __init__(self, steps_done: Callable[[int], None]) -> None:
        self.steps_done = steps_done

    def on_train_start(self, trainer: lightning.Trainer, *_: Any) -> None:
        self.steps_done(trainer.global_step)

    def on_train_batch_end(self, trainer: lightning.Trainer, *_: Any) -> None:
        self.steps_done(trainer.global_step)
