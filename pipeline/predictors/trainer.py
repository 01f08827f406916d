"""Runs Lightning's trainer without its messages, resumable after every epoch."""

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
from lightning.pytorch.callbacks import Callback, LearningRateMonitor, ModelCheckpoint
from lightning.pytorch.loggers.logger import Logger
from lightning.pytorch.plugins.io import TorchCheckpointIO
from lightning.pytorch.strategies import DDPStrategy
from lightning.pytorch.utilities import rank_zero_only
from lightning.pytorch.utilities.exceptions import SIGTERMException

from rallygap.models.predictors.settings import TrainingSettings
from rallygap.models.predictors.training import ForecastTraining, WindowData
from rallygap.pipeline.io.artifacts import replacing
from rallygap.pipeline.runtime.errors import InputError
from rallygap.pipeline.tracking.live import LiveRun


def train(
    training: ForecastTraining,
    data: WindowData,
    checkpoints: Path,
    callbacks: Sequence[Callback] = (),
    live: LiveRun | None = None,
) -> None:
    """Train a network in place.

    Every epoch writes a checkpoint, from which a killed run resumes with the same result as an
    uninterrupted one.

    Args:
        training: the network and its settings.
        data: the windows.
        checkpoints: a folder for this training alone.
        callbacks: additional ones.
        live: the MLflow run that gets losses and learning rates after every epoch, if any.

    Raises:
        InputError: fewer GPUs are available than ``devices``.
        SystemExit: the process received SIGTERM.
    """
    torch.set_num_threads(training.settings.threads)
    last = checkpoints / "last.ckpt"
    resumed = last if last.exists() else None
    with _quiet(), tempfile.TemporaryDirectory() as rendezvous:
        try:
            trainer = _trainer(training.settings, checkpoints, callbacks, Path(rendezvous), live)
        except MisconfigurationException as error:
            where = "train_predictor.training.devices"
            raise InputError("params.yaml", " ".join(str(error).split()), field=where) from None
        try:
            trainer.fit(training, data, ckpt_path=resumed, weights_only=False)
        except SIGTERMException:
            # Lightning would end the process with status 0, as if it had finished.
            raise SystemExit(128 + signal.SIGTERM) from None
    if training.settings.devices > 1:  # Lightning returns only the weights from other processes
        training.on_load_checkpoint(torch.load(last, weights_only=False))


def _trainer(
    settings: TrainingSettings,
    checkpoints: Path,
    callbacks: Sequence[Callback],
    rendezvous: Path,
    live: LiveRun | None,
) -> lightning.Trainer:
    every_epoch = ModelCheckpoint(
        dirpath=checkpoints,
        filename="last",
        enable_version_counter=False,
        save_on_train_epoch_end=True,
    )
    own: list[Callback] = [every_epoch]
    logger: Any = False
    if live is not None:
        own.append(LearningRateMonitor("epoch"))
        logger = LiveLogger(live)
    alone = settings.devices == 1
    return lightning.Trainer(
        devices=settings.devices,
        strategy="auto" if alone else LoopbackDDP(rendezvous / "processes", settings.threads),
        use_distributed_sampler=False,  # WindowData shares batches itself
        max_epochs=settings.epochs,
        precision=settings.precision,
        gradient_clip_val=settings.max_gradient_norm,
        deterministic=True,
        # Batches depend on the number of the epoch.
        reload_dataloaders_every_n_epochs=1,
        callbacks=[*own, *callbacks],
        plugins=[AtomicCheckpointIO()],
        default_root_dir=checkpoints,
        logger=logger,
        enable_progress_bar=False,
        enable_model_summary=False,
        num_sanity_val_steps=0,
    )


class LiveLogger(Logger):
    """Adds a training's losses and learning rates to a run that others write and end."""

    name = version = None  # of folders, which it does not write

    def __init__(self, live: LiveRun) -> None:
        super().__init__()
        self.live = live

    @rank_zero_only
    def log_metrics(self, metrics: dict[str, float], step: int | None = None) -> None:
        """Add metrics at an optimizer step."""
        self.live.log(metrics, step or 0)

    def log_hyperparams(self, *_: Any, **__: Any) -> None:
        """The run has the parameters of its stage."""


class AtomicCheckpointIO(TorchCheckpointIO):
    """Writes checkpoints atomically, so that a full disk keeps the previous one.

    Lightning writes to a temporary folder and moves, which across file systems is a copy.
    """

    def save_checkpoint(
        self, checkpoint: dict[str, Any], path: str | Path, storage_options: Any = None
    ) -> None:
        """Write a checkpoint with Python, because torch does not report a full disk."""
        content = io.BytesIO()
        torch.save(checkpoint, content)
        with replacing(Path(path)) as temporary:
            temporary.write_bytes(content.getbuffer())


class LoopbackDDP(DDPStrategy):
    """Distributed data parallel on the devices of one machine.

    The rendezvous is a file and the traffic uses loopback, so no port is open to the network.

    Args:
        rendezvous: path of a file that does not exist yet.
        threads: per process.
    """

    def __init__(self, rendezvous: Path, threads: int) -> None:
        super().__init__(start_method="spawn")
        self.rendezvous, self.threads = rendezvous, threads

    def setup_distributed(self) -> None:
        """Join the process group; this runs in every process."""
        _silence()
        torch.set_num_threads(self.threads)
        torch.set_flush_denormal(True)
        os.environ["GLOO_SOCKET_IFNAME"] = os.environ["NCCL_SOCKET_IFNAME"] = next(
            name
            for name, addresses in psutil.net_if_addrs().items()
            if any(address.address == "127.0.0.1" for address in addresses)
        )
        self.set_world_ranks()
        torch.distributed.init_process_group(
            self._get_process_group_backend(),
            init_method=self.rendezvous.as_uri(),
            rank=self.global_rank,
            world_size=self.world_size,
        )
        super().setup_distributed()


@contextmanager
def _quiet() -> Iterator[None]:
    """Suppress Lightning's messages within this block, and take denormal numbers for zero.

    The gradients of units that no longer respond become denormal, and Intel's processors then take
    25 to 170 times longer for Muon's step, for changes that no weight can show.
    """
    with warnings.catch_warnings():
        _silence()
        torch.set_flush_denormal(True)
        try:
            yield
        finally:
            torch.set_flush_denormal(False)


def _silence() -> None:
    logging.getLogger("lightning.pytorch").setLevel(logging.ERROR)
    warnings.filterwarnings("ignore", module=r"lightning\.")


class StepReporter(Callback):
    """Reports the number of finished steps, at the start and after each step."""

    def __init__(self, steps_done: Callable[[int], None]) -> None:
        self.steps_done = steps_done

    def on_train_start(self, trainer: lightning.Trainer, *_: Any) -> None:
        """Report the step to start from."""
        self.steps_done(trainer.global_step)

    def on_train_batch_end(self, trainer: lightning.Trainer, *_: Any) -> None:
        """Report a finished step."""
        self.steps_done(trainer.global_step)
