"""Networks that learn from the training recordings of one arena."""

from pathlib import Path

from rallygap.models.predictors.learned import LearnedPredictor
from rallygap.models.predictors.settings import NetworkSettings
from rallygap.models.predictors.training import ForecastTraining, WindowData
from rallygap.pipeline.evaluation.predictors import ARENA
from rallygap.pipeline.params import Params
from rallygap.pipeline.predictors.trainer import train
from rallygap.pipeline.predictors.training_data import TrainingEpisodes, untrained_network

NETWORKS = ("transformer", "hybrid")


def trained_networks(params: Params, seed: int, artifacts: Path) -> dict[str, LearnedPredictor]:
    """Train networks as ``train_predictor`` does, one after another.

    Args:
        params: settings of the networks and of their training.
        seed: of weights and windows.
        artifacts: folder of recordings and episodes; checkpoints go there, too.
    """
    settings = params.train_predictor
    data = TrainingEpisodes(artifacts, seed).window_data([ARENA], settings.training)
    return {
        name: _trained(settings.networks[name], data, artifacts / "checkpoints" / name)
        for name in NETWORKS
    }


def _trained(settings: NetworkSettings, data: WindowData, checkpoints: Path) -> LearnedPredictor:
    network = untrained_network(settings, data)
    train(ForecastTraining(network, data.settings), data, checkpoints)
    return LearnedPredictor(network)  # no spread: only mean errors are compared
