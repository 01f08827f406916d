"""The trajectory autoencoders: their layers written out, what is hidden from them, their sizes."""

from dataclasses import replace

import numpy as np
import pytest
import torch
from torch import nn

from models.predictors.gru_tae import RecurrentAutoencoder
from models.predictors.learned import LearnedPredictor
from models.predictors.protocol import History
from models.predictors.tae import TrajectoryAutoencoder
from models.predictors.training import ForecastTraining, WindowData
from models.predictors.window_dataset import build_tracks
from tests.models.predictors.balls import FIRST, observed
from tests.models.predictors.episodes import flown
from tests.models.predictors.schooling import (
    BRIEF,
    TINY_GRU_TAE,
    TINY_TAE,
    changed,
    fit,
    network,
    schooling,
)

SETTINGS = [TINY_TAE, TINY_GRU_TAE]
KINDS = [settings.kind for settings in SETTINGS]


@pytest.fixture(params=[False, True], ids=["plain", "told of uniform motion"])
def told(request):
    """Whether a network is told of uniform motion."""
    return request.param


@pytest.fixture
def tae(told):
    """A small autoencoder whose every weight is random."""
    return randomised(TrajectoryAutoencoder(20, 14, 8, 24, told))


@pytest.fixture
def gru_tae(told):
    """A small recurrent autoencoder whose every weight is random."""
    return randomised(RecurrentAutoencoder(14, 8, 20, told))


@pytest.fixture(params=KINDS)
def autoencoder(request, tae, gru_tae):
    """Either of them."""
    return {"tae": tae, "gru_tae": gru_tae}[request.param]


def randomised(network):
    random = torch.Generator().manual_seed(0)
    for weight in network.parameters():
        nn.init.normal_(weight, std=0.3, generator=random)
    return network.double()


@pytest.fixture(scope="module")
def balls():
    """Histories of three balls, where they were seen, their residuals and uniform motions."""
    random = torch.Generator().manual_seed(1)
    shapes = [(3, 12, 6), (3, 12, 3), (3, 60, 6)]
    history, *rest = (torch.randn(one, dtype=torch.float64, generator=random) for one in shapes)
    seen = torch.rand(3, 12, 6, generator=random) < 0.8
    return [torch.where(seen, history, 0.0), seen, *rest]


def linear(weights, name, numbers):
    return numbers @ weights[f"{name}.weight"].T + weights[f"{name}.bias"]


def rows(told, history, seen, residual):
    """(B, 12, 12 or 15) what is read of a row."""
    return torch.cat([history, seen.double(), *([residual] if told else [])], dim=2)


def test_the_forward_of_the_autoencoder_is_its_layers_written_out(tae, told, balls):
    weights, read = tae.state_dict(), rows(told, *balls[:3]).reshape(3, -1)
    features = {}
    for name in ("encoder", "decoder"):
        wide = linear(weights, f"{name}.projection", read).clamp(min=0)
        features[name] = linear(weights, f"{name}.inner", wide).clamp(min=0)
    code = linear(weights, "code", features["encoder"])
    joined = linear(weights, "joined", torch.cat([features["decoder"], code], 1)).clamp(min=0)
    expected = linear(weights, "projection", joined).reshape(3, 60, 9)
    torch.testing.assert_close(tae(*balls), expected, rtol=0, atol=1e-12)


def test_the_forward_of_the_recurrent_one_is_its_gates_written_out(gru_tae, told, balls):
    weights, read = gru_tae.state_dict(), rows(told, *balls[:3])
    for unit in ("encoder.0.projections", "encoder.1.projections"):
        read = unit_written_out(weights, unit, read)
    dense = linear(weights, "decoder", read[:, -1])
    dense = torch.where(dense > 0, dense, dense.exp() - 1)
    expected = linear(weights, "projection", dense).reshape(3, 60, 9)
    torch.testing.assert_close(gru_tae(*balls), expected, rtol=0, atol=1e-12)


def unit_written_out(weights, unit, read):
    """Cho 2014, with the candidate's own bias inside the reset, as torch and Keras have it."""
    new, old = (
        (weights[f"{unit}.weight_{part}_l0"], weights[f"{unit}.bias_{part}_l0"])
        for part in ("ih", "hh")
    )
    held = torch.zeros(len(read), new[0].shape[0] // 3, dtype=read.dtype)
    after = []
    for row in read.unbind(1):
        reset, update, candidate = (row @ new[0].T + new[1]).chunk(3, 1)
        old_reset, old_update, old_candidate = (held @ old[0].T + old[1]).chunk(3, 1)
        share = (update + old_update).sigmoid()
        candidate = (candidate + (reset + old_reset).sigmoid() * old_candidate).tanh()
        held = (1 - share) * candidate + share * held
        after.append(held)
    return torch.stack(after, 1)


def dense(inputs, outputs):
    return (inputs + 1) * outputs


def test_in_its_authors_size_the_autoencoder_has_as_many_numbers_as_counted_by_hand():
    reading = dense(12 * 12, 512) + dense(512, 128)
    whole = 2 * reading + dense(128, 64) + dense(128 + 64, 1024) + dense(1024, 60 * 9)
    assert sum(one.numel() for one in authors_size("tae").parameters()) == whole == 1_039_196


def test_in_its_authors_size_the_recurrent_one_has_as_many_numbers_as_counted_by_hand():
    units = sum(3 * (dense(inputs, own) + dense(own, own)) for inputs, own in [(12, 64), (64, 16)])
    whole = units + dense(16, 128) + dense(128, 60 * 9)
    assert sum(one.numel() for one in authors_size("gru_tae").parameters()) == whole == 90_748


def authors_size(kind):
    with torch.device("meta"):
        if kind == "tae":
            return TrajectoryAutoencoder(512, 128, 64, 1024, uniform_motion=False)
        return RecurrentAutoencoder(64, 16, 128, uniform_motion=False)


@pytest.mark.parametrize("settings", SETTINGS, ids=KINDS)
def test_what_the_mask_hides_changes_no_forecast(settings):
    predictor = LearnedPredictor(network(settings))
    seen, _ = observed(noise=0.003)
    states, mask = torch.from_numpy(seen.states).float(), torch.from_numpy(seen.mask).clone()
    mask[:, 3:5] = False
    mask[0, :, 3:] = False
    with torch.inference_mode():
        hidden = [predictor.network(torch.where(mask, states, other), mask) for other in (0, 7.0)]
        shown = predictor.network(states, mask | True)
    assert torch.equal(*hidden)
    assert not torch.equal(hidden[0], shown)


@pytest.mark.parametrize("settings", SETTINGS, ids=KINDS)
def test_a_handful_of_windows_is_learned_by_heart(settings):
    flights = build_tracks([flown(first) for first in FIRST])
    one_each = replace(flights, anchors=flights.anchors[flights.bounds[:-1]], bounds=np.arange(4))
    plain = changed(BRIEF, epochs=6, windows_an_episode=100, batch=6, decay=0.6, hidden_spin=0.0)
    training = ForecastTraining(network(settings), plain)
    windows = WindowData(one_each, one_each, plain, seed=0)
    windows.fit_normaliser(training.network)
    curve = fit(training, windows).curve
    history, seen, future, _ = map(np.asarray, one_each.windows(one_each.anchors))
    forecast = LearnedPredictor(training.network).predict(History(history, seen)).states
    assert curve[-1]["validation"] < 0.01  # a network that says nothing loses 3
    assert np.linalg.norm((forecast - future)[:, -1, :3], axis=1).max() < 0.06


@pytest.mark.parametrize("settings", SETTINGS, ids=KINDS)
def test_muon_and_adam_share_its_weights_and_both_train(settings):
    muon = changed(BRIEF, matrix_learning_rate=0.01, epochs=1)
    training, windows = schooling(muon, shape=settings)
    before = {name: one.clone() for name, one in training.network.named_parameters()}
    fit(training, windows)
    after = dict(training.network.named_parameters())
    assert not any(torch.equal(before[name], after[name]) for name in before)
