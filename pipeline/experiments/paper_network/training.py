"""Training of the paper's network on a GPU, and the trained network as a file."""

from pathlib import Path
from typing import Any

import torch
from safetensors.torch import load_file, save

from rallygap.models.predictors.learned import ForecastNetwork, build_network
from rallygap.models.predictors.settings import NetworkSettings, TrainingSettings
from rallygap.models.predictors.training import WindowData
from rallygap.pipeline.experiments.paper_network.prepared import PreparedData, PreparedTraining
from rallygap.pipeline.io.artifacts import read_json, replacing, write_json
from rallygap.pipeline.predictors.parallel_training import TrainingJob
from rallygap.pipeline.predictors.trainer import StepReporter, train
from rallygap.pipeline.predictors.training_data import untrained_network
from rallygap.pipeline.runtime.errors import InputError
from rallygap.pipeline.runtime.progress import WatchedBars

WEIGHTS, RECORD = "weights.safetensors", "training.json"
# In 32 bits the GPU itself takes longer than its processor to start a step. The paper's last 20 of
# 80 epochs have less than a twentieth of the first learning rate.
PRECISION, EPOCHS = "bf16-mixed", 60


def on_gpu(settings: TrainingSettings) -> TrainingSettings:
    """Return the paper's settings with fewer bits and fewer epochs."""
    return settings.model_copy(update={"precision": PRECISION, "epochs": EPOCHS})


def check_gpu(folder: Path) -> None:
    """Refuse to go on without a GPU and without a trained network in the folder.

    Raises:
        InputError: there is neither.
    """
    if not (folder / RECORD).exists() and not torch.cuda.is_available():
        raise InputError("the paper's network", "is trained on a GPU; torch finds none here")


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
