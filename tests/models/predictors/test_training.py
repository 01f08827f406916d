"""Training: learning rates, losses, masks and batches."""

from dataclasses import replace

import numpy as np
import pytest
import torch

from rallygap.models.predictors.learned import ForecastNetwork, LearnedPredictor
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


class ZeroNetwork(torch.nn.Module):
    """A network whose output is zero."""

    def forward(self, history, *_):
        return history.new_zeros(len(history), 60, 9)


class RecordedRates(ForecastTraining):
    """A training that records its learning rates."""

    def on_train_start(self):
        self.rates = []

    def on_train_batch_start(self, *_):
        self.rates.append(self.optimizers().param_groups[0]["lr"])


def weights(training):
    return [weight.detach().clone() for weight in training.network.parameters()]


def batches(loader):
    return [[part.numpy() for part in batch] for batch in loader]


def joined(loader):
    """The parts of all batches, each in one array."""
    return [np.concatenate(parts) for parts in zip(*batches(loader), strict=True)]


@pytest.mark.parametrize(
    "shape",
    [changed(TINY, width=32, expanded=64), TINY_TAE, TINY_GRU_TAE],
    ids=lambda one: one.kind,
)
def test_a_network_overfits_three_windows(shape):
    flights = build_tracks([flown(first) for first in FIRST])
    one_each = replace(flights, anchors=flights.anchors[flights.bounds[:-1]], bounds=np.arange(4))
    settings = changed(
        BRIEF, epochs=6, windows_per_episode=100, batch=6, decay=0.6, hidden_spin=0.0
    )
    training = ForecastTraining(network(shape), settings)
    windows = WindowData(one_each, one_each, settings, seed=0)
    windows.fit_normaliser(training.network)
    curve = fit(training, windows).curve
    history, seen, future, measured = map(np.asarray, one_each.windows(one_each.anchors))
    forecast = LearnedPredictor(training.network).predict(History(history, seen)).states
    assert measured[:, -1].all()
    assert curve[-1]["validation"] < 0.01  # a forecast of the mean has a loss of 3
    assert np.linalg.norm((forecast - future)[:, -1, :3], axis=1).max() < 0.06


def test_the_loss_of_the_mean_forecast_is_the_variance():
    train = tracks(6, 0)
    batch = train.windows(train.anchors)
    training = ForecastTraining(ForecastNetwork(ZeroNetwork()), BRIEF)
    training.network.normaliser.fit(*batch, uniform_motion(*batch[:2]))
    motion = uniform_motion(*batch[:2])
    wanted = training.network.normaliser.deviation(batch[2], motion)[batch[3]]
    assert training._loss(batch)[0].item() == pytest.approx(wanted.square().mean().item(), rel=1e-5)
    numbers = batch[3].sum(dim=(0, 1)).view(3, 3).sum(dim=1)
    variances = np.square([3.0, 1.0, 0.5])  # the weights of position, velocity and spin
    expected = np.average(variances, weights=numbers)
    assert training._loss(batch)[0].item() == pytest.approx(expected, rel=1e-2)


def test_unmeasured_values_have_no_gradient():
    training, windows = small_training()
    history, seen, future, measured = next(iter(windows.train_dataloader()))
    assert not seen.all() and not measured.all()
    nonsense = torch.where(seen, history, 1e6), seen, torch.where(measured, future, 1e6), measured
    gradients = []
    for batch in [(history, seen, future, measured), nonsense]:
        training.zero_grad()
        training._loss(batch)[0].backward()
        gradients.append([weight.grad for weight in training.network.parameters()])
    assert all(torch.equal(one, other) for one, other in zip(*gradients, strict=True))


def test_a_batch_without_measurements_has_zero_loss():
    training, windows = small_training()
    history, seen, future, measured = next(iter(windows.train_dataloader()))
    assert training._loss((history, seen, future, torch.zeros_like(measured)))[0].item() == 0.0


def hiding(share, **changes):
    return joined(data(changed(BRIEF, hidden_spin=share, **changes)).train_dataloader())


def test_hidden_spin_is_masked_in_input_and_loss():
    (history, seen, future, measured), hidden = hiding(0.0), hiding(1.0)
    np.testing.assert_array_equal(hidden[0][..., :3], history[..., :3])
    np.testing.assert_array_equal(hidden[1][..., :3], seen[..., :3])
    np.testing.assert_array_equal(hidden[2], future)
    np.testing.assert_array_equal(hidden[3][..., :6], measured[..., :6])
    assert not hidden[3][..., 6:].any() and measured[..., 6:].any()
    assert seen[..., 3:].any() and history[..., 3:].any()
    assert not hidden[1][..., 3:].any() and not hidden[0][..., 3:].any()


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


def test_the_requested_share_of_windows_has_hidden_spin():
    whole, some = (hiding(share, windows_per_episode=100)[1][..., 3:] for share in (0.0, 0.3))
    hidden = ~some.any(axis=(1, 2))
    assert hidden.mean() == pytest.approx(0.3, abs=0.06)  # of 600 windows: three deviations
    np.testing.assert_array_equal(some[~hidden], whole[~hidden])


def test_an_epoch_has_the_requested_number_of_windows_per_episode():
    train = tracks(6, 0)
    every = train.windows(train.anchors)[2].numpy()
    owner = np.repeat(np.arange(6), np.diff(train.bounds))
    loader = data().train_dataloader()
    drawn = [owner[(every == window).all(axis=(1, 2))].tolist() for window in joined(loader)[2]]
    assert sorted(drawn) == [[episode] for episode in range(6) for _ in range(4)]
    assert [len(batch[0]) for batch in loader] == [8, 8, 8]


class RecordedBatches(ForecastTraining):
    """A training that records its batches."""

    def on_fit_start(self):
        self.training_batches, self.validation_batches = [], []

    def on_train_batch_start(self, batch, _):
        self.training_batches.append(batch[0].cpu().numpy())

    def on_validation_batch_start(self, batch, *_):
        self.validation_batches.append(batch[0].cpu().numpy())


def test_every_epoch_draws_new_training_windows_and_the_same_validation_windows():
    training = fit(*small_training(kind=RecordedBatches))
    learned, watched = np.split(np.array(training.training_batches), 3), training.validation_batches
    assert (learned[0] != learned[1]).any() and (learned[1] != learned[2]).any()
    assert len(watched) == 3
    np.testing.assert_array_equal(watched[0], watched[1])
    np.testing.assert_array_equal(watched[0], watched[2])


def test_validation_changes_no_weight():
    training, windows = small_training()
    other, others = small_training()
    others.validation = tracks(5, 7)
    pairs = zip(weights(fit(training, windows)), weights(fit(other, others)), strict=True)
    assert all(torch.equal(one, same) for one, same in pairs)
    assert training.curve != other.curve


def test_exponential_decay_of_the_learning_rate():
    training = fit(*small_training(kind=RecordedRates))
    assert training.rates == pytest.approx(np.repeat([0.01, 0.005, 0.0025], 3))


def test_cosine_schedule_of_the_learning_rate():
    settings = changed(BRIEF, decay=None, epochs=10, learning_rate=1e-4)
    rates = np.array(fit(*small_training(settings, kind=RecordedRates)).rates)
    assert rates == pytest.approx([1e-4 * cosine(step / 30) for step in range(30)])


def test_cosine_schedule_has_a_linear_warm_up():
    shares = [0.0, 0.025, 0.05, 0.25, 0.5, 1.0, 1.1]
    falling = (1 + np.cos(np.pi * np.array(shares[:-1]))) / 2
    assert [cosine(share) for share in shares] == pytest.approx(
        [0.0, falling[1] / 2, *falling[2:], 0.0]
    )
