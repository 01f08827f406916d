"""Training of learned predictors as Lightning modules: the training step and the data."""

import math
import time
from typing import Any

import lightning
import numpy as np
import torch
from torch import Tensor
from torch.optim import Adam, Optimizer
from torch.optim.lr_scheduler import ExponentialLR, LambdaLR
from torch.utils.data import DataLoader, Dataset

from rallygap.models.predictors.learned import ForecastNetwork
from rallygap.models.predictors.optimizer import MuonAndAdam
from rallygap.models.predictors.settings import TrainingSettings
from rallygap.models.predictors.window_dataset import Indices, Tracks

Batch = tuple[Tensor, Tensor, Tensor, Tensor]

# Each use of randomness has its own stream, next to the seed.
_VALIDATION, _FITTING, _EPOCHS = 0, 1, 2
WARM_UP = 0.05  # of all steps, over which the learning rate of the cosine rises
HUBER = 1.0  # normalised error from which a hybrid's counts linearly
LARGEST_FIT = 20_000  # windows for the normaliser's statistics; more change less than 0.1 %


def cosine(share: float) -> float:
    """Return the learning rate's factor after a share of all steps: warm-up and half a cosine."""
    return min(1.0, share / WARM_UP) * 0.5 * (1.0 + math.cos(math.pi * min(share, 1.0)))


class ForecastTraining(lightning.LightningModule):
    """Trains a network on the mean squared error of normalised, measured states.

    A hybrid is trained on Huber's loss of the same errors instead.

    As in the paper (section IV-A) with Adam and a learning rate that decays by a factor per epoch;
    optionally with Muon for the layers' matrices and a cosine schedule.

    Attributes:
        curve: one record per epoch: training loss and validation loss.
        seconds: duration of the training, killed runs included up to their last epoch.
    """

    def __init__(self, network: ForecastNetwork, settings: TrainingSettings) -> None:
        super().__init__()
        self.network, self.settings = network, settings
        self.curve: list[dict[str, float]] = []
        self.seconds = 0.0
        self._since = 0.0

    def training_step(self, batch: Batch) -> Tensor:
        """Return the loss of a batch."""
        loss, size = self._loss(batch)
        self.log("training", loss, on_step=False, on_epoch=True, batch_size=size, sync_dist=True)
        return loss

    def validation_step(self, batch: Batch) -> None:
        """Log the loss of a validation batch."""
        loss, size = self._loss(batch)
        self.log("validation", loss, batch_size=size, sync_dist=True)

    def configure_optimizers(self) -> Any:
        """Return the optimizer and its schedule."""
        rate, matrix_rate = self.settings.learning_rate, self.settings.matrix_learning_rate
        optimizer: Optimizer = Adam(self.network.parameters(), lr=rate)
        if matrix_rate is not None:
            optimizer = MuonAndAdam(self.network, rate, matrix_rate)
        if self.settings.decay is not None:
            return [optimizer], [ExponentialLR(optimizer, self.settings.decay)]
        steps = int(self.trainer.estimated_stepping_batches)
        schedule = LambdaLR(optimizer, lambda step: cosine(step / steps))
        return [optimizer], [{"scheduler": schedule, "interval": "step"}]

    def on_train_epoch_start(self) -> None:
        """Start timing the epoch."""
        self._since = time.monotonic()

    def on_train_epoch_end(self) -> None:
        """Append the epoch to the curve."""
        self.seconds += time.monotonic() - self._since
        known = self.trainer.callback_metrics
        losses = {name: float(known[name]) for name in ("validation", "training")}
        self.curve.append({"epoch": self.current_epoch + 1, **losses})

    def on_save_checkpoint(self, checkpoint: dict[str, Any]) -> None:
        """Save curve and duration, to resume from."""
        checkpoint["curve"], checkpoint["seconds"] = self.curve, self.seconds

    def on_load_checkpoint(self, checkpoint: dict[str, Any]) -> None:
        """Restore curve and duration."""
        self.curve, self.seconds = checkpoint["curve"], checkpoint["seconds"]

    def _loss(self, batch: Batch) -> tuple[Tensor, int]:
        """Return the loss of this process's share of a batch, and the windows of the whole batch.

        Processes average their gradients, so all shares need the same denominator: the mean number
        of measured values per process. Their average is then the loss of the whole batch.
        """
        history, mask, future, measured = batch
        motion = self.network.baseline(history, mask)
        wanted = self.network.normaliser.deviation(future, motion)
        output = self.network.deviation(history, mask, motion)
        squares = self._squares(torch.where(measured, output - wanted, 0.0))
        if not torch.distributed.is_initialized():
            return squares.sum() / measured.sum().clamp(min=1), len(history)
        counts = torch.stack([measured.sum(), measured.new_tensor(len(history), dtype=torch.long)])
        torch.distributed.all_reduce(counts)
        mean = counts[0] / torch.distributed.get_world_size()
        return squares.sum() / mean.clamp(min=1), int(counts[1])

    def _squares(self, errors: Tensor) -> Tensor:
        """Return what errors count: their squares, of a hybrid by Huber's loss (1964).

        Most of what a simulator leaves is small, and few balls that hit the net are far off.
        """
        if self.network.simulator is None:
            return errors.square()
        size = errors.abs()
        return torch.where(size < HUBER, errors.square(), HUBER * (2 * size - HUBER))


class WindowData(lightning.LightningDataModule):
    """Windows drawn from tracks; each epoch's draws depend on the seed and the epoch's number.

    Processes that train together draw the same batches, and each takes its share of every batch.

    Args:
        train: training tracks.
        validation: validation tracks, with one fixed window per episode.
        settings: batch size, windows per episode and share of hidden spins.
        seed: of every draw.
    """

    def __init__(
        self, train: Tracks, validation: Tracks, settings: TrainingSettings, seed: int
    ) -> None:
        super().__init__()
        self.train, self.validation, self.settings, self.seed = train, validation, settings, seed
        self._placed = train, validation

    def fit_normaliser(self, network: ForecastNetwork) -> None:
        """Fit the network's normaliser to training windows."""
        window = self._fitting_windows()
        network.normaliser.fit(*window, network.baseline(*window[:2]))

    def fit_outputs(self, network: ForecastNetwork) -> None:
        """Fit the scale of a network's outputs alone, whose baseline is another one now."""
        history, mask, future, measured = self._fitting_windows()
        motion = network.baseline(history, mask)
        network.normaliser.fit_outputs(future, measured, motion)

    def _fitting_windows(self) -> Batch:
        random = np.random.default_rng([self.seed, _FITTING])
        episodes = random.integers(0, self.train.episodes, LARGEST_FIT)
        return self.train.windows(self.train.draw_anchors(episodes, random))

    def setup(self, stage: str) -> None:
        """Copy the tracks to the training device, once for all epochs."""
        assert self.trainer is not None
        device = self.trainer.strategy.root_device
        self._placed = self.train.to(device), self.validation.to(device)

    def train_dataloader(self) -> DataLoader[Batch]:
        """Return the batches of the trainer's current epoch."""
        epoch = self.trainer.current_epoch if self.trainer else 0
        random = np.random.default_rng([self.seed, _EPOCHS, epoch])
        every = np.repeat(np.arange(self.train.episodes), self.settings.windows_per_episode)
        return self._loader(self._placed[0], random.permutation(every), random)

    def val_dataloader(self) -> DataLoader[Batch]:
        """Return the validation batches, the same in every epoch."""
        random = np.random.default_rng([self.seed, _VALIDATION])
        return self._loader(self._placed[1], np.arange(self.validation.episodes), random)

    def _loader(
        self, tracks: Tracks, episodes: Indices, random: np.random.Generator
    ) -> DataLoader[Batch]:
        anchors = tracks.draw_anchors(episodes, random)
        hidden = random.random(len(anchors)) < self.settings.hidden_spin
        share = (self.trainer.global_rank, self.trainer.world_size) if self.trainer else (0, 1)
        batches = _Batches(tracks, anchors, hidden, self.settings.batch, share)
        return DataLoader(batches, batch_size=None)


class _Batches(Dataset[Batch]):
    """The batches of an epoch; an item is one process's share of a batch."""

    def __init__(
        self,
        tracks: Tracks,
        anchors: Indices,
        hidden: "np.ndarray[Any, Any]",
        batch: int,
        share: tuple[int, int],
    ) -> None:
        self.tracks, self.anchors, self.hidden, self.batch = tracks, anchors, hidden, batch
        self.rank, self.processes = share

    def __len__(self) -> int:
        return -(-len(self.anchors) // self.batch)

    def __getitem__(self, number: int) -> Batch:
        if number >= len(self):
            raise IndexError(number)
        end = min((number + 1) * self.batch, len(self.anchors))
        part = slice(number * self.batch + self.rank, end, self.processes)
        history, mask, future, measured = self.tracks.windows(self.anchors[part])
        hidden = torch.from_numpy(self.hidden[part]).to(mask.device)
        history[hidden, :, 3:] = 0.0
        mask[hidden, :, 3:] = False
        # Nor does it count in the loss: the path hardly determines it, so its error would dominate.
        measured[~mask[:, :, 3:].any(dim=(1, 2)), :, 6:] = False
        return history, mask, future, measured
