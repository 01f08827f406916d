"""The trajectory autoencoders against explicit equations, masks, and parameter counts."""

import pytest
import torch
from torch import nn

from rallygap.models.predictors.autoencoders import RecurrentAutoencoder, TrajectoryAutoencoder
from rallygap.models.predictors.learned import LearnedPredictor
from tests.models.predictors.balls import observed
from tests.models.predictors.small_training import (
    TINY_GRU_TAE,
    TINY_TAE,
    network,
)

SETTINGS = [TINY_TAE, TINY_GRU_TAE]
KINDS = [settings.kind for settings in SETTINGS]


@pytest.fixture(params=[False, True], ids=["plain", "uniform motion"])
def uniform_motion(request):
    """Whether a network is uniform motion."""
    return request.param


@pytest.fixture
def tae(uniform_motion):
    """A small autoencoder whose every weight is random."""
    return randomised(TrajectoryAutoencoder(20, 14, 8, 24, uniform_motion))


@pytest.fixture
def gru_tae(uniform_motion):
    """A small recurrent autoencoder whose every weight is random."""
    return randomised(RecurrentAutoencoder(14, 8, 20, uniform_motion))


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


def rows(uniform_motion, history, seen, residual):
    """(B, 12, 12 or 15) what is read of a row."""
    return torch.cat([history, seen.double(), *([residual] if uniform_motion else [])], dim=2)


def test_autoencoder_equals_its_explicit_equations(tae, uniform_motion, balls):
    weights, read = tae.state_dict(), rows(uniform_motion, *balls[:3]).reshape(3, -1)
    features = {}
    for name in ("encoder", "decoder"):
        wide = linear(weights, f"{name}.projection", read).clamp(min=0)
        features[name] = linear(weights, f"{name}.inner", wide).clamp(min=0)
    code = linear(weights, "code", features["encoder"])
    joined = linear(weights, "joined", torch.cat([features["decoder"], code], 1)).clamp(min=0)
    expected = linear(weights, "projection", joined).reshape(3, 60, 9)
    torch.testing.assert_close(tae(*balls), expected, rtol=0, atol=1e-12)


def test_recurrent_autoencoder_equals_its_explicit_equations(gru_tae, uniform_motion, balls):
    weights, read = gru_tae.state_dict(), rows(uniform_motion, *balls[:3])
    for unit in ("encoder.0.projections", "encoder.1.projections"):
        read = explicit_gru(weights, unit, read)
    dense = linear(weights, "decoder", read[:, -1])
    dense = torch.where(dense > 0, dense, dense.exp() - 1)
    expected = linear(weights, "projection", dense).reshape(3, 60, 9)
    torch.testing.assert_close(gru_tae(*balls), expected, rtol=0, atol=1e-12)


def explicit_gru(weights, unit, read):
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


@pytest.mark.parametrize("settings", SETTINGS, ids=KINDS)
def test_masked_values_do_not_change_the_forecast(settings):
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


@pytest.mark.parametrize(
    ("kind", "sizes", "parameters"),
    [
        (
            TrajectoryAutoencoder,
            (512, 128, 64, 1024),
            2 * (145 * 512 + 513 * 128) + 129 * 64 + 193 * 1024 + 1025 * 540,
        ),
        (
            RecurrentAutoencoder,
            (64, 16, 128),
            3 * (13 + 65) * 64 + 3 * (65 + 17) * 16 + 17 * 128 + 129 * 540,
        ),
    ],
)
def test_published_sizes_have_the_published_number_of_parameters(kind, sizes, parameters):
    with torch.device("meta"):
        network = kind(*sizes, uniform_motion=False)
    counts = {TrajectoryAutoencoder: 1_039_196, RecurrentAutoencoder: 90_748}
    assert sum(one.numel() for one in network.parameters()) == parameters == counts[kind]
