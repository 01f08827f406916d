"""Runs Lightning for a stage: on what there is, quietly, and so that it can resume."""

import io
import logging
import os
import signal
import tempfile
import warnings
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import lightning
import psutil
import torch
from lightning.fabric.utilities.exceptions import MisconfigurationException
from lightning.pytorch.callbacks import Callback, ModelCheckpoint
from lightning.pytorch.plugins.io import TorchCheckpointIO
from lightning.pytorch.strategies import DDPStrategy
from lightning.pytorch.utilities.exceptions import SIGTERMException

from models.predictors.settings import TrainingSettings
from models.predictors.training import ForecastTraining, WindowData
from pipeline.io.artifacts import replacing
from pipeline.runtime.errors import InputError


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
        InputError: there are fewer GPUs than devices asked for.
        SystemExit: the process was told to stop (SIGTERM).
    """
    torch.set_num_threads(training.settings.threads)
    last = checkpoints / "last.ckpt"
    resumed = last if last.exists() else None
    with _quiet(), tempfile.TemporaryDirectory() as meeting:
        trainer = _trainer(training.settings, checkpoints, watchers, Path(meeting))
        try:
            trainer.fit(training, data, ckpt_path=resumed, weights_only=False)
        except SIGTERMException:
            # Lightning's would end the process with status 0, as if all were done.
            raise SystemExit(128 + signal.SIGTERM) from None
    if training.settings.devices > 1:  # of what other processes did, Lightning brings the weights
        training.on_load_checkpoint(torch.load(last, weights_only=False))


def _trainer(
    settings: TrainingSettings, checkpoints: Path, watchers: Sequence[Callback], meeting: Path
) -> lightning.Trainer:
    try:
        return _configured(settings, checkpoints, watchers, meeting)
    except MisconfigurationException as error:
        where = "train_predictor.training.devices"
        raise InputError("params.yaml", " ".join(str(error).split()), field=where) from None


def _configured(
    settings: TrainingSettings, checkpoints: Path, watchers: Sequence[Callback], meeting: Path
) -> lightning.Trainer:
    alone = settings.devices == 1
    return lightning.Trainer(
        devices=settings.devices,
        strategy="auto" if alone else SideBySide(meeting / "processes", settings.threads),
        use_distributed_sampler=False,  # the data know how to share
        max_epochs=settings.epochs,
        precision=settings.precision,
        gradient_clip_val=settings.longest_gradient,
        deterministic=True,
        # Batches depend on the number of the epoch.
        reload_dataloaders_every_n_epochs=1,
        callbacks=[_saved_every_epoch(checkpoints), *watchers],
        plugins=[WholeCheckpoints()],
        default_root_dir=checkpoints,
        logger=False,
        enable_progress_bar=False,
        enable_model_summary=False,
        num_sanity_val_steps=0,
    )


class WholeCheckpoints(TorchCheckpointIO):
    """Checkpoints that appear whole or not at all, so that a full disk leaves the one before.

    Lightning's own are written elsewhere and moved, which on another disk is a copy.
    """

    def save_checkpoint(
        self, checkpoint: dict[str, Any], path: str | Path, storage_options: Any = None
    ) -> None:
        """Write a checkpoint, by Python: torch's own writing does not say that a disk is full."""
        content = io.BytesIO()
        torch.save(checkpoint, content)
        with replacing(Path(path)) as temporary:
            temporary.write_bytes(content.getbuffer())


class SideBySide(DDPStrategy):
    """Distributed data parallel on the devices of one machine.

    Processes meet through a file and talk over loopback, so nothing listens beyond the machine.

    Args:
        meeting: a file that is not there yet.
        threads: of each process.
    """

    def __init__(self, meeting: Path, threads: int) -> None:
        super().__init__(start_method="spawn")
        self.meeting, self.threads = meeting, threads

    def setup_distributed(self) -> None:
        """Meet the other processes; what is set here is set in each."""
        _hush()
        torch.set_num_threads(self.threads)
        os.environ["GLOO_SOCKET_IFNAME"] = os.environ["NCCL_SOCKET_IFNAME"] = _loopback()
        self.set_world_ranks()
        torch.distributed.init_process_group(
            self._get_process_group_backend(),
            init_method=self.meeting.as_uri(),
            rank=self.global_rank,
            world_size=self.world_size,
        )
        super().setup_distributed()


def _loopback() -> str:
    """Return what this machine calls the interface with which it talks to itself."""
    names = (
        name
        for name, addresses in psutil.net_if_addrs().items()
        if any(one.address == "127.0.0.1" for one in addresses)
    )
    return next(names)


@contextmanager
def _quiet() -> Iterator[None]:
    """Leave out Lightning's advice and advertisements."""
    with warnings.catch_warnings():
        _hush()
        yield


def _hush() -> None:
    logging.getLogger("lightning.pytorch").setLevel(logging.ERROR)
    warnings.filterwarnings("ignore", module=r"lightning\.")


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
        """Tell where it starts from."""
        self.steps_done(trainer.global_step)

    def on_train_batch_end(self, trainer: lightning.Trainer, *_: Any) -> None:
        """Tell how far it has come."""
        self.steps_done(trainer.global_step)
