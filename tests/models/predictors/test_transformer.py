"""The transformer against torch's own layers, its parts put together as the paper says."""

import itertools

import numpy as np
import pytest
import torch
from torch import nn
from torch.nn.functional import conv1d, linear

from rallygap.models.predictors.transformer import Transformer, sinusoids
from tests.models.predictors.small_training import random_inputs, random_weights

HEADS, ENCODER_LAYERS, DECODER_LAYERS = 4, 3, 2
WIDTH, EXPANDED = 32, 48


@pytest.fixture(scope="module", params=itertools.product([1, 5], [False, True]))
def network(request):
    """A small transformer whose every weight, those of layer normalisation too, is random."""
    sizes = WIDTH, EXPANDED, HEADS, ENCODER_LAYERS, DECODER_LAYERS
    return random_weights(Transformer(*sizes, *request.param))


def places(length, width):
    """Vaswani 2017: sines in the even channels, cosines in the odd, ever slower; in float32."""
    place, channel = np.mgrid[:length, :width]
    angle = place / 10000 ** (channel // 2 * 2 / width)
    return torch.from_numpy(np.where(channel % 2 == 0, np.sin(angle), np.cos(angle)))


PARTS = {"self_attn": "attention", "multihead_attn": "crossing"}  # torch's names and ours
BLOCK = {"linear1": "block.expand", "linear2": "block.contract"}
NORMS = ("after_attention", "after_crossing", "after_block")


def torch_layer(kind, weights, name):
    """torch's layer with our weights: attention, in a decoder crossing, and block, each normed."""
    layer = kind(WIDTH, HEADS, EXPANDED, dropout=0, activation="gelu", batch_first=True).double()
    parts = {theirs: part for theirs, part in PARTS.items() if hasattr(layer, theirs)}
    norms = [norm for norm in NORMS if f"{name}.{norm}.weight" in weights]
    ours = BLOCK | {f"norm{k}": norm for k, norm in enumerate(norms, 1)}
    ours |= {f"{theirs}.out_proj": f"{part}.merged" for theirs, part in parts.items()}
    state = {}
    for end in ("weight", "bias"):
        state |= {f"{one}.{end}": weights[f"{name}.{own}.{end}"] for one, own in ours.items()}
        for theirs, part in parts.items():
            projections = [weights[f"{name}.{part}.{p}.{end}"] for p in ("query", "key", "value")]
            state[f"{theirs}.in_proj_{end}"] = torch.cat(projections)
    layer.load_state_dict(state)
    return layer


def restated(network, history, _seen, residual, expected):
    """Section III-A: placeholders after the history, and layers normed after each residual."""
    weights = network.state_dict()
    states_per_row = len(weights["projection.bias"]) // 9
    placeholders = torch.zeros(len(history), 60 // states_per_row, 6, dtype=history.dtype)
    if network.uniform_motion:
        history = torch.cat([history, residual], 2)
        last_of_each_row = expected[:, states_per_row - 1 :: states_per_row]
        placeholders = torch.cat([last_of_each_row, placeholders[..., :3]], 2)

    def embedded(name, rows):
        taps, bias = (weights[f"{name}.projection.{end}"] for end in ("weight", "bias"))
        return conv1d(rows.mT, taps, bias, padding=1).mT + places(rows.shape[1], WIDTH)

    encoded = embedded("encoder_embedding", history)
    for k in range(ENCODER_LAYERS):
        encoded = torch_layer(nn.TransformerEncoderLayer, weights, f"encoder.{k}")(encoded)
    decoded = embedded("decoder_embedding", torch.cat([history, placeholders], 1))
    for k in range(DECODER_LAYERS):
        decoded = torch_layer(nn.TransformerDecoderLayer, weights, f"decoder.{k}")(decoded, encoded)
    future = linear(decoded, weights["projection.weight"], weights["projection.bias"])
    return future[:, 12:].reshape(-1, 60, 9)


def test_transformer_equals_torchs_own_layers_in_double_precision(network, monkeypatch):
    balls = random_inputs()
    for embedding in (network.encoder_embedding, network.decoder_embedding):
        monkeypatch.setitem(embedding._buffers, "positions", places(*embedding.positions.shape))
    with torch.no_grad():
        wanted = restated(network, *balls)
        torch.testing.assert_close(network(*balls), wanted, rtol=0, atol=1e-10)


@pytest.mark.parametrize("width", [8, 512])
def test_positional_encoding_is_sinusoidal(width):
    torch.testing.assert_close(sinusoids(72, width), places(72, width).float(), rtol=0, atol=1e-5)


def test_in_the_paper_s_size_it_has_12_6_million_parameters():
    with torch.device("meta"):
        network = Transformer(512, 1024, 8, 3, 2, 1, False)
    count = sum(weight.numel() for weight in network.parameters())
    assert round(count / 1e6, 1) == 12.6
