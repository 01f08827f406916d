"""The paper's network, trained on a GPU with less work per step.

The paper's batches are small: starting the kernels of a step takes a processor longer than running
them takes a GPU. So the windows of many batches are gathered and normalised at once, and the
network's kernels start together, as one CUDA graph.
"""

from copy import copy
from pathlib import Path
from typing import Any

import torch
from safetensors.torch import load_file, save
from torch import Tensor
from torch.utils.data import DataLoader, Dataset

from rallygap.models.predictors.learned import ForecastNetwork, build_network
from rallygap.models.predictors.settings import NetworkSettings
from rallygap.models.predictors.training import Batch, ForecastTraining, WindowData
from rallygap.models.predictors.window_dataset import Indices, Tracks
from rallygap.pipeline.io.artifacts import read_json, replacing, write_json
from rallygap.pipeline.predictors.parallel_training import TrainingJob
from rallygap.pipeline.predictors.trainer import StepReporter, train
from rallygap.pipeline.predictors.training_data import untrained_network
from rallygap.pipeline.runtime.progress import WatchedBars

WEIGHTS, RECORD = "weights.safetensors", "training.json"
AT_ONCE = 64  # batches that are gathered and normalised together
# The network's four inputs, its expected output, and where that is measured.
Prepared = tuple[Tensor, ...]


class PreparedTraining(ForecastTraining):
    """A training on the batches of ``PreparedData``."""

    def use_graphs(self) -> None:
        """Compile the network to CUDA graphs."""
        self.network.network.compile(mode="reduce-overhead", dynamic=False)

    def _loss(self, batch: Prepared) -> tuple[Tensor, int]:
        *inputs, expected, measured = batch
        errors = torch.where(measured, self.network.network(*inputs) - expected, 0.0)
        return self._squares(errors).sum() / measured.sum().clamp(min=1), len(expected)


class PreparedData(WindowData):
    """The windows of ``WindowData`` in the same batches, normalised for a network, on one device.

    Args:
        data: tracks, settings and seed.
        network: whose normaliser has been fitted.
    """

    def __init__(self, data: WindowData, network: ForecastNetwork) -> None:
        super().__init__(data.train, data.validation, data.settings, data.seed)
        self.network = network

    def _loader(self, tracks: Tracks, episodes: Indices, random: Any) -> DataLoader[Any]:
        loader = super()._loader(tracks, episodes, random)
        return DataLoader(PreparedBatches(loader.dataset, self.network), batch_size=None)


class PreparedBatches(Dataset[Prepared]):
    """Batches that are prepared in groups; they are to be read in order.

    Args:
        batches: of windows.
        network: that normalises them.
    """

    def __init__(self, batches: Any, network: ForecastNetwork) -> None:
        self.count, self.batch, self.network = len(batches), batches.batch, network
        self.groups = copy(batches)
        self.groups.batch *= AT_ONCE
        self.group: Prepared = ()

    def __len__(self) -> int:
        return self.count

    def __getitem__(self, number: int) -> Prepared:
        group, position = divmod(number, AT_ONCE)
        if position == 0:
            self.group = self._prepared(self.groups[group])
        first = position * self.batch
        return tuple(values[first : first + self.batch] for values in self.group)

    @torch.no_grad()
    def _prepared(self, windows: Batch) -> Prepared:
        history, mask, future, measured = windows
        normaliser = self.network.normaliser
        motion = self.network.baseline(history, mask)
        return (
            normaliser.normalised(history, mask, motion),
            mask,
            normaliser.residual(history, mask, motion),
            normaliser.expected(motion),
            normaliser.deviation(future, motion),
            measured,
        )


def write_trained(name: str, settings: NetworkSettings, data: WindowData, folder: Path) -> None:
    """Train a network and write it to a folder, in which a killed training resumes.

    Args:
        name: of the progress bar.
        settings: of the network.
        data: windows, and the settings of training.
        folder: of ``WEIGHTS`` and ``RECORD``.
    """
    network, gpu = untrained_network(settings, data), torch.cuda.is_available()
    training, prepared = PreparedTraining(network, data.settings), PreparedData(data, network)
    if gpu:
        training.use_graphs()
    job, done = TrainingJob(name, network, prepared, folder / "checkpoints"), [0]
    with WatchedBars({name: job.steps}, lambda: done):
        reporter = StepReporter(lambda steps: done.__setitem__(0, steps))
        train(training, prepared, job.folder, [reporter])
    with replacing(folder / WEIGHTS) as temporary:
        temporary.write_bytes(save(network.state_dict()))
    record = {
        "gpu": torch.cuda.get_device_name() if gpu else None,
        "training_s": round(training.seconds, 1),
        "training_episodes": data.train.episodes,
        "curve": training.curve,
    }
    write_json(folder / RECORD, record)


def read_trained_network(
    settings: NetworkSettings, folder: Path
) -> tuple[ForecastNetwork, dict[str, Any]]:
    """Return a network that ``write_trained`` has written, and the record of its training."""
    network = build_network(settings)
    network.load_state_dict(load_file(folder / WEIGHTS))
    return network.eval(), dict(read_json(folder / RECORD))
