"""The transformer against the paper's equations on plain tensors."""

import itertools

import numpy as np
import pytest
import torch
from torch import nn

from rallygap.models.predictors.transformer import Transformer, sinusoids

HEADS, ENCODER_LAYERS, DECODER_LAYERS = 4, 3, 2


@pytest.fixture(scope="module", params=itertools.product([1, 5], [False, True]))
def network(request):
    """A small transformer whose every weight, those of layer normalisation too, is random."""
    random = torch.Generator().manual_seed(0)
    network = Transformer(32, 48, HEADS, ENCODER_LAYERS, DECODER_LAYERS, *request.param).double()
    for weight in network.parameters():
        nn.init.normal_(weight, std=0.3, generator=random)
    return network


@pytest.fixture(scope="module")
def balls():
    """Histories, where seen, how far off uniform motion and where that leads: any numbers."""
    random = torch.Generator().manual_seed(1)
    shapes = [(3, 12, 6), (3, 12, 3), (3, 60, 6)]
    history, *rest = (torch.randn(one, dtype=torch.float64, generator=random) for one in shapes)
    return [history, torch.ones_like(history, dtype=torch.bool), *rest]


class Restated:
    """Section III-A on plain tensors.

    B balls, T times, C channels in, D channels out, H heads, Q asking and K asked times.
    """

    def __init__(self, network):
        self.weights, self.uniform_motion = network.state_dict(), network.uniform_motion

    def __call__(self, history, seen, residual, expected):
        states_per_row = len(self.weights["projection.bias"]) // 9
        placeholders = torch.zeros(len(history), 60 // states_per_row, 6, dtype=history.dtype)
        if self.uniform_motion:
            history = torch.cat([history, residual], 2)
            last_of_each_row = expected[:, states_per_row - 1 :: states_per_row]
            placeholders = torch.cat([last_of_each_row, placeholders[..., :3]], 2)
        encoded = self.embedded("encoder_embedding", history)
        for layer in range(ENCODER_LAYERS):
            encoded = self.encoder_layer(f"encoder.{layer}", encoded)
        decoded = self.embedded("decoder_embedding", torch.cat([history, placeholders], 1))
        for layer in range(DECODER_LAYERS):
            decoded = self.decoder_layer(f"decoder.{layer}", decoded, encoded)
        return self.linear("projection", decoded)[:, 12:].reshape(-1, 60, 9)

    def encoder_layer(self, name, rows):
        attended = self.attention(f"{name}.attention", rows, rows) + rows
        attended = self.normalised(f"{name}.after_attention", attended)
        return self.normalised(f"{name}.after_block", self.block(name, attended) + attended)

    def decoder_layer(self, name, rows, encoded):
        attended = self.attention(f"{name}.attention", rows, rows) + rows
        attended = self.normalised(f"{name}.after_attention", attended)
        crossed = self.attention(f"{name}.crossing", attended, encoded) + attended
        crossed = self.normalised(f"{name}.after_crossing", crossed)
        return self.normalised(f"{name}.after_block", self.block(name, crossed) + crossed)

    def attention(self, name, asking, asked):
        query = self.heads(self.linear(f"{name}.query", asking))
        key, value = (self.heads(self.linear(f"{name}.{part}", asked)) for part in ("key", "value"))
        scores = torch.einsum("bqhc,bkhc->bhqk", query, key) / query.shape[-1] ** 0.5
        shares = scores.exp() / scores.exp().sum(-1, keepdim=True)
        found = torch.einsum("bhqk,bkhc->bqhc", shares, value)
        return self.linear(f"{name}.merged", found.flatten(2))

    def block(self, name, rows):
        return self.linear(
            f"{name}.block.contract", gelu(self.linear(f"{name}.block.expand", rows))
        )

    def embedded(self, name, rows):
        """Convolution over three samples, nothing before the first and after the last; places."""
        taps = self.weights[f"{name}.projection.weight"]
        nothing = torch.zeros_like(rows[:, :1])
        around = torch.cat([nothing, rows, nothing], 1)
        shifted = (around[:, tap : tap + rows.shape[1]] for tap in range(3))
        summed = sum(
            torch.einsum("btc,dc->btd", row, taps[:, :, tap]) for tap, row in enumerate(shifted)
        )
        return summed + self.weights[f"{name}.projection.bias"] + places(*summed.shape[1:])

    def normalised(self, name, rows):
        centred = rows - rows.mean(-1, keepdim=True)
        variance = (centred**2).mean(-1, keepdim=True)
        scaled = centred / (variance + 1e-5) ** 0.5
        return scaled * self.weights[f"{name}.weight"] + self.weights[f"{name}.bias"]

    def linear(self, name, rows):
        weight, bias = self.weights[f"{name}.weight"], self.weights[f"{name}.bias"]
        return torch.einsum("btc,dc->btd", rows, weight) + bias

    def heads(self, rows):
        return rows.unflatten(2, (HEADS, -1))


def places(length, width):
    """Vaswani 2017: sines in the even channels, cosines in the odd, ever slower; in float32."""
    place, channel = np.mgrid[:length, :width]
    angle = place / 10000 ** (channel // 2 * 2 / width)
    return torch.from_numpy(np.where(channel % 2 == 0, np.sin(angle), np.cos(angle)))


def gelu(numbers):
    """Hendrycks 2016: a number times the share of a normal distribution that is below it."""
    return numbers * (1 + torch.erf(numbers / 2**0.5)) / 2


def test_transformer_equals_the_equations_in_double_precision(network, balls, monkeypatch):
    for embedding in (network.encoder_embedding, network.decoder_embedding):
        monkeypatch.setitem(embedding._buffers, "positions", places(*embedding.positions.shape))
    with torch.no_grad():
        torch.testing.assert_close(network(*balls), Restated(network)(*balls), rtol=0, atol=1e-10)


@pytest.mark.parametrize("width", [8, 64, 512])
def test_positional_encoding_is_sinusoidal(width):
    torch.testing.assert_close(sinusoids(72, width), places(72, width).float(), rtol=0, atol=1e-5)


def test_in_the_paper_s_size_it_has_12_6_million_parameters():
    with torch.device("meta"):
        network = Transformer(512, 1024, 8, 3, 2, 1, False)
    count = sum(weight.numel() for weight in network.parameters())
    assert round(count / 1e6, 1) == 12.6
