"""A small network, a few balls and a short training, for the tests of learned predictors."""

import copy
from functools import cache

import lightning
import numpy as np
import torch
from torch import nn

from rallygap.models.predictors.learned import build_network
from rallygap.models.predictors.settings import (
    GruTaeSettings,
    HybridSettings,
    TaeSettings,
    TrainingSettings,
    TransformerSettings,
)
from rallygap.models.predictors.training import ForecastTraining, WindowData
from rallygap.models.predictors.window_dataset import build_tracks
from tests.models.predictors.balls import FIRST
from tests.models.predictors.episodes import degraded, flown

# With so little work, two threads lose more time waiting for each other than they save.
torch.set_num_threads(1)

TINY = TransformerSettings(
    kind="transformer", width=16, expanded=32, heads=2, encoder_layers=1, decoder_layers=1,
    states_per_row=5, uniform_motion=True,
)  # fmt: skip
TINY_HYBRID = HybridSettings.model_validate(
    {**TINY.model_dump(), "kind": "hybrid", "simulator": "imperfect_c_with_net"}
)
TINY_TAE = TaeSettings(
    kind="tae", hidden=32, features=16, latent=8, decoded=32, uniform_motion=True
)  # fmt: skip
TINY_GRU_TAE = GruTaeSettings(
    kind="gru_tae", recurrent=16, latent=8, decoded=16, uniform_motion=True
)  # fmt: skip
NETWORKS = {one.kind: one for one in (TINY, TINY_TAE, TINY_GRU_TAE)}
BRIEF = TrainingSettings(
    epochs=3, windows_per_episode=4, batch=8, learning_rate=0.01, matrix_learning_rate=None,
    decay=0.5, max_gradient_norm=1.0, hidden_spin=0.3, precision="32-true", threads=1,
)  # fmt: skip


def changed(settings, **changes):
    return settings.model_validate({**settings.model_dump(), **changes})


def network(settings=TINY, seed=0):
    torch.manual_seed(seed)
    return build_network(settings)


def random_weights(network):
    """The network in double precision, every weight of it random."""
    generator = torch.Generator().manual_seed(0)
    for weight in network.parameters():
        nn.init.normal_(weight, std=0.3, generator=generator)
    return network.double()


def random_inputs():
    """Of a network, for three balls: histories, where seen, residuals and uniform motions."""
    generator = torch.Generator().manual_seed(1)
    shapes = [(3, 12, 6), (3, 12, 3), (3, 60, 6)]
    history, *rest = (torch.randn(one, dtype=torch.float64, generator=generator) for one in shapes)
    seen = torch.rand(3, 12, 6, generator=generator) < 0.8
    return [torch.where(seen, history, 0.0), seen, *rest]


@cache
def tracks(count, seed):
    """Tracks of balls like ``FIRST``, with noise, outliers and lost samples."""
    random = np.random.default_rng(seed)
    first = FIRST[np.arange(count) % 3] * random.uniform(0.97, 1.03, (count, 9))
    flights = (flown(one, noise=0.003, spin_noise=10.0, seed=seed) for one in first)
    return build_tracks([degraded(flight, number) for number, flight in enumerate(flights)])


def data(settings=BRIEF):
    return WindowData(tracks(6, 0), tracks(3, 1), settings, seed=0)


@cache
def _fitted(shape):
    fresh = network(shape)
    data().fit_normaliser(fresh)
    return fresh


def small_training(settings=BRIEF, kind=ForecastTraining, shape=TINY):
    """A training of a fresh network, and its data."""
    return kind(copy.deepcopy(_fitted(shape)), settings), data(settings)


def fit(training, data, accelerator="auto"):
    """Train without checkpoints and reports."""
    trainer = lightning.Trainer(
        accelerator=accelerator,
        max_epochs=training.settings.epochs,
        reload_dataloaders_every_n_epochs=1,
        logger=False,
        enable_checkpointing=False,
        enable_progress_bar=False,
        enable_model_summary=False,
        num_sanity_val_steps=0,
    )
    trainer.fit(training, data)
    return training
