"""Training: learning rates, losses, masks and batches."""

from dataclasses import replace

import numpy as np
import pytest
import torch

from rallygap.models.predictors.learned import LearnedPredictor
from rallygap.models.predictors.normaliser import uniform_motion
from rallygap.models.predictors.protocol import History
from rallygap.models.predictors.training import ForecastTraining, WindowData, cosine
from rallygap.models.predictors.window_dataset import build_tracks
from tests.models.predictors.balls import FIRST
from tests.models.predictors.episodes import flown
from tests.models.predictors.small_training import (
    BRIEF,
    TINY,
    TINY_GRU_TAE,
    TINY_TAE,
    changed,
    data,
    fit,
    network,
    small_training,
    tracks,
)


def joined(loader):
    """The parts of all batches, each in one array."""
    return [np.concatenate(parts) for parts in zip(*loader, strict=True)]


@pytest.mark.parametrize(
    "shape",
    [changed(TINY, width=32, expanded=64), TINY_TAE, TINY_GRU_TAE],
    ids=lambda one: one.kind,
)
def test_a_network_overfits_three_windows(shape):
    flights = build_tracks([flown(first) for first in FIRST])
    one_each = replace(flights, anchors=flights.anchors[flights.bounds[:-1]], bounds=np.arange(4))
    settings = changed(BRIEF, epochs=5, windows_per_episode=80, batch=6, decay=0.5, hidden_spin=0.0)
    training = ForecastTraining(network(shape), settings)
    windows = WindowData(one_each, one_each, settings, seed=0)
    windows.fit_normaliser(training.network)
    curve = fit(training, windows).curve
    history, seen, future, measured = map(np.asarray, one_each.windows(one_each.anchors))
    forecast = LearnedPredictor(training.network).predict(History(history, seen)).states
    assert measured[:, -1].all()
    assert curve[-1]["validation"] < 0.05  # a forecast of the mean has a loss of 3
    assert np.linalg.norm((forecast - future)[:, -1, :3], axis=1).max() < 0.12


def test_the_loss_is_the_mean_square_of_what_is_measured():
    """Of a network that says zero, which is the mean."""
    train = tracks(6, 0)
    batch = train.windows(train.anchors)
    training = ForecastTraining(network(TINY), BRIEF)
    training.network.network.start_at_baseline()
    motion = uniform_motion(*batch[:2])
    training.network.normaliser.fit(*batch, motion)
    wanted = training.network.normaliser.deviation(batch[2], motion)[batch[3]]
    assert training._loss(batch)[0].item() == pytest.approx(wanted.square().mean().item(), rel=1e-5)
    assert training._loss((*batch[:3], torch.zeros_like(batch[3])))[0].item() == 0.0


def test_the_requested_share_of_windows_has_spin_hidden_in_input_and_loss():
    (history, seen, future, measured), some = (
        joined(data(changed(BRIEF, hidden_spin=share, windows_per_episode=100)).train_dataloader())
        for share in (0.0, 0.3)
    )
    hidden = ~some[1][..., 3:].any(axis=(1, 2))
    assert hidden.mean() == pytest.approx(0.3, abs=0.06)  # of 600 windows: three deviations
    for found, whole in zip(some, (history, seen, future, measured), strict=True):
        np.testing.assert_array_equal(found[~hidden], whole[~hidden])
    np.testing.assert_array_equal(some[0][..., :3], history[..., :3])
    np.testing.assert_array_equal(some[1][..., :3], seen[..., :3])
    np.testing.assert_array_equal(some[2], future)
    np.testing.assert_array_equal(some[3][..., :6], measured[..., :6])
    assert measured[hidden, :, 6:].any() and history[hidden, :, 3:].any()
    assert not some[3][hidden, :, 6:].any() and not some[0][hidden, :, 3:].any()


def test_spin_without_a_label_in_the_history_is_masked_in_the_loss():
    late = flown()
    late.spins[:50] = np.nan  # so that some windows see no label, but have one in their future
    settings = changed(BRIEF, hidden_spin=0.0, windows_per_episode=100)
    windows = WindowData(build_tracks([late]), build_tracks([late]), settings, seed=0)
    _, seen, future, measured = joined(windows.train_dataloader())
    labelled = seen[..., 3:].any(axis=(1, 2))
    assert labelled.any() and future[~labelled, :, 6:].any()
    assert measured[labelled, :, 6:].any(axis=(1, 2)).all()
    assert not measured[~labelled, :, 6:].any()


def test_an_epoch_has_the_requested_number_of_windows_per_episode():
    train = tracks(6, 0)
    every = train.windows(train.anchors)[2].numpy()
    owner = np.repeat(np.arange(6), np.diff(train.bounds))
    loader = data().train_dataloader()
    drawn = [owner[(every == window).all(axis=(1, 2))].tolist() for window in joined(loader)[2]]
    assert sorted(drawn) == [[episode] for episode in range(6) for _ in range(4)]
    assert [len(batch[0]) for batch in loader] == [8, 8, 8]


class Recorded(ForecastTraining):
    """A training that records its learning rates and batches."""

    def on_fit_start(self):
        self.rates, self.training_batches, self.validation_batches = [], [], []

    def on_train_batch_start(self, batch, _):
        self.rates.append(self.optimizers().param_groups[0]["lr"])
        self.training_batches.append(batch[0].cpu().numpy())

    def on_validation_batch_start(self, batch, *_):
        self.validation_batches.append(batch[0].cpu().numpy())


def test_every_epoch_has_new_training_windows_the_same_validation_windows_and_a_lower_rate():
    recorded = fit(*small_training(kind=Recorded))
    learned, watched = np.split(np.array(recorded.training_batches), 3), recorded.validation_batches
    assert (learned[0] != learned[1]).any() and (learned[1] != learned[2]).any()
    assert len(watched) == 3
    np.testing.assert_array_equal(watched[0], watched[1])
    np.testing.assert_array_equal(watched[0], watched[2])
    assert recorded.rates == pytest.approx(np.repeat([0.01, 0.005, 0.0025], 3))


def test_cosine_schedule_of_the_learning_rate_has_a_linear_warm_up():
    settings = changed(BRIEF, decay=None, epochs=7, learning_rate=1e-4)
    rates = np.array(fit(*small_training(settings, kind=Recorded)).rates)
    assert rates == pytest.approx([1e-4 * cosine(step / 21) for step in range(21)])
    shares = [0.0, 0.025, 0.05, 0.25, 0.5, 1.0, 1.1]
    falling = (1 + np.cos(np.pi * np.array(shares[:-1]))) / 2
    expected = [0.0, falling[1] / 2, *falling[2:], 0.0]
    assert [cosine(share) for share in shares] == pytest.approx(expected)
