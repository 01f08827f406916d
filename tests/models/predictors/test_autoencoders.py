"""The trajectory autoencoders against explicit equations and published parameter counts."""

import pytest
import torch
from torch import nn

from rallygap.models.predictors.autoencoders import RecurrentAutoencoder, TrajectoryAutoencoder
from tests.models.predictors.small_training import random_inputs, random_weights


def linear(weights, name, numbers):
    return numbers @ weights[f"{name}.weight"].T + weights[f"{name}.bias"]


def rows(uniform_motion, history, seen, residual):
    """(B, 12, 12 or 15) what is read of a row."""
    return torch.cat([history, seen.double(), *([residual] if uniform_motion else [])], dim=2)


@pytest.mark.parametrize("uniform_motion", [False, True])
def test_autoencoder_equals_its_explicit_equations(uniform_motion):
    balls = random_inputs()
    tae = random_weights(TrajectoryAutoencoder(20, 14, 8, 24, uniform_motion))
    weights, read = tae.state_dict(), rows(uniform_motion, *balls[:3]).reshape(3, -1)
    features = {}
    for name in ("encoder", "decoder"):
        wide = linear(weights, f"{name}.projection", read).clamp(min=0)
        features[name] = linear(weights, f"{name}.inner", wide).clamp(min=0)
    code = linear(weights, "code", features["encoder"])
    joined = linear(weights, "joined", torch.cat([features["decoder"], code], 1)).clamp(min=0)
    expected = linear(weights, "projection", joined).reshape(3, 60, 9)
    torch.testing.assert_close(tae(*balls), expected, rtol=0, atol=1e-12)


@pytest.mark.parametrize("uniform_motion", [False, True])
def test_recurrent_autoencoder_equals_its_explicit_equations(uniform_motion):
    balls = random_inputs()
    gru_tae = random_weights(RecurrentAutoencoder(14, 8, 20, uniform_motion))
    weights, read = gru_tae.state_dict(), rows(uniform_motion, *balls[:3])
    for unit, width in (("encoder.0.projections", 14), ("encoder.1.projections", 8)):
        gru = nn.GRU(read.shape[2], width, batch_first=True).double()
        gru.load_state_dict({name: weights[f"{unit}.{name}"] for name in gru.state_dict()})
        read = gru(read)[0]
    dense = linear(weights, "decoder", read[:, -1])
    dense = torch.where(dense > 0, dense, dense.exp() - 1)
    expected = linear(weights, "projection", dense).reshape(3, 60, 9)
    torch.testing.assert_close(gru_tae(*balls), expected, rtol=0, atol=1e-12)


@pytest.mark.parametrize(
    ("kind", "sizes", "parameters"),
    [
        (TrajectoryAutoencoder, (512, 128, 64, 1024), 1_039_196),
        (RecurrentAutoencoder, (64, 16, 128), 90_748),
    ],
)
def test_published_sizes_have_the_published_number_of_parameters(kind, sizes, parameters):
    with torch.device("meta"):
        network = kind(*sizes, uniform_motion=False)
    assert sum(one.numel() for one in network.parameters()) == parameters
