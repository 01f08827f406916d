"""The transformer of the paper: from twelve measured states to sixty future states in one pass.

Bi et al., *Bridging the sim2real gap in the table tennis robot with a transformer-based ball states
predictor*, section III-A. An encoder reads the history; a decoder reads the history again, followed
by one placeholder row for every future state (zeros in the paper), and attends to the encoder's
output. It is not autoregressive, so errors do not accumulate along the horizon.

The paper leaves open: the padding of the input convolution (zeros here), the kernel of the blocks'
convolutions (1: 12.6 million parameters in the paper's size), the activation between them (GELU),
a mask in the decoder's self-attention (none: no output is fed back) and dropout (none: every window
is seen about once).
"""

import math

import torch
from torch import Tensor, nn
from torch.nn.functional import gelu, pad, scaled_dot_product_attention

from rallygap.models.predictors.normaliser import INPUTS, OUTPUTS, RESIDUALS
from rallygap.models.predictors.protocol import FUTURE, HISTORY

# (B, T, width) rows, or several such tensors whose rows follow one another. A compiler calculates
# once what is made of a tensor that depends on no input.
Rows = Tensor | tuple[Tensor, ...]


class Attention(nn.Module):
    """Multi-head scaled dot-product attention (Vaswani 2017)."""

    def __init__(self, width: int, heads: int) -> None:
        super().__init__()
        self.heads = heads
        self.query, self.key, self.value, self.merged = (nn.Linear(width, width) for _ in range(4))

    def forward(self, queries: Rows, memory: Rows) -> Tensor:
        """Return (B, Q, width): ``queries`` of that shape attend to (B, K, width) ``memory``."""
        query, key = self._heads(self.query, queries), self._heads(self.key, memory)
        attended = scaled_dot_product_attention(query, key, self._heads(self.value, memory))
        return self.merged(attended.transpose(1, 2).flatten(2))

    def _heads(self, projection: nn.Module, parts: Rows) -> Tensor:
        """Return (B, heads, T, width / heads) projections."""
        if isinstance(parts, Tensor):
            parts = (parts,)
        rows = torch.cat([projection(part) for part in parts], dim=1)
        count, times, width = rows.shape
        return rows.view(count, times, self.heads, width // self.heads).transpose(1, 2)


class ConvolutionBlock(nn.Module):
    """Two convolutions along time, out to ``expanded`` channels and back.

    With a kernel of one sample they are linear maps of each row, and are computed as such.
    """

    def __init__(self, width: int, expanded: int) -> None:
        super().__init__()
        self.expand, self.contract = nn.Linear(width, expanded), nn.Linear(expanded, width)

    def forward(self, rows: Tensor) -> Tensor:
        """Return (B, T, width) of the same shape."""
        return self.contract(gelu(self.expand(rows)))


class EncoderLayer(nn.Module):
    """Self-attention and convolution block, each with a residual and layer normalisation."""

    def __init__(self, width: int, expanded: int, heads: int) -> None:
        super().__init__()
        self.attention, self.block = Attention(width, heads), ConvolutionBlock(width, expanded)
        self.after_attention, self.after_block = nn.LayerNorm(width), nn.LayerNorm(width)

    def forward(self, rows: Tensor) -> Tensor:
        """Return (B, T, width) of the same shape."""
        attended = self.after_attention(self.attention(rows, rows) + rows)
        return self.after_block(self.block(attended) + attended)


class DecoderLayer(nn.Module):
    """An encoder layer with attention to the encoder's output between its two halves."""

    def __init__(self, width: int, expanded: int, heads: int) -> None:
        super().__init__()
        self.attention, self.crossing = Attention(width, heads), Attention(width, heads)
        self.block = ConvolutionBlock(width, expanded)
        self.after_attention, self.after_crossing, self.after_block = (
            nn.LayerNorm(width) for _ in range(3)
        )

    def forward(self, rows: Rows, encoded: Tensor, read: slice | None = None) -> Tensor:
        """Return (B, T, width) of the same shape, or of those ``rows`` alone that are read."""
        own = torch.cat(rows, dim=1) if isinstance(rows, tuple) else rows
        own = own[:, read] if read else own
        attended = self.after_attention(self.attention(own if read else rows, rows) + own)
        crossed = self.after_crossing(self.crossing(attended, encoded) + attended)
        return self.after_block(self.block(crossed) + crossed)


class Embedding(nn.Module):
    """Projects rows of measurements to the layers' width and adds the positional encoding."""

    positions: Tensor

    def __init__(self, inputs: int, length: int, width: int) -> None:
        super().__init__()
        self.projection = nn.Conv1d(inputs, width, kernel_size=3, padding=1)
        self.register_buffer("positions", sinusoids(length, width), persistent=False)

    def forward(self, rows: Tensor) -> Tensor:
        """Return (B, T, width) of (B, T, inputs) normalised rows."""
        projected = self.projection(rows.transpose(1, 2)).transpose(1, 2)
        return projected + self.positions[: rows.shape[1]]

    def of_zeros(self, count: int, first: int) -> Tensor:
        """Return (count, T, width) of rows of zeros from ``first`` on, after one of zeros."""
        assert self.projection.bias is not None  # by default
        rows = self.projection.bias + self.positions[first:]
        return rows.expand(count, -1, -1)


class Transformer(nn.Module):
    """The network, on normalised states; ``TransformerSettings`` describes its arguments."""

    def __init__(
        self,
        width: int,
        expanded: int,
        heads: int,
        encoder_layers: int,
        decoder_layers: int,
        states_per_row: int,
        uniform_motion: bool,
    ) -> None:
        super().__init__()
        self.uniform_motion = uniform_motion
        inputs = INPUTS + RESIDUALS * uniform_motion
        self.rows, self.read = FUTURE // states_per_row, slice(0, FUTURE // states_per_row)
        self.encoder_embedding = Embedding(inputs, HISTORY, width)
        self.decoder_embedding = Embedding(inputs, HISTORY + self.rows, width)
        self.encoder = nn.ModuleList(
            EncoderLayer(width, expanded, heads) for _ in range(encoder_layers)
        )
        self.decoder = nn.ModuleList(
            DecoderLayer(width, expanded, heads) for _ in range(decoder_layers)
        )
        self.projection = nn.Linear(width, states_per_row * OUTPUTS)

    def start_at_baseline(self) -> None:
        """Let the untrained network say that the baseline is right."""
        nn.init.zeros_(self.projection.weight)
        nn.init.zeros_(self.projection.bias)

    def read_only(self, states: slice) -> None:
        """Forecast some of the future states alone, which takes less time; others are NaN.

        Args:
            states: that are read, of the 60.
        """
        size = FUTURE // self.rows
        self.read = slice(states.start // size, -(-states.stop // size))

    def forward(self, history: Tensor, mask: Tensor, residual: Tensor, expected: Tensor) -> Tensor:
        """Return (B, 60, 9) normalised deviations from the baseline (``ForecastNetwork``).

        As in the paper, the network does not read the mask.
        """
        if self.uniform_motion:
            history = torch.cat([history, residual], dim=2)
        encoded = self.encoder_embedding(history)
        for layer in self.encoder:
            encoded = layer(encoded)
        decoded = self._embedded(history, expected)
        for layer in self.decoder[:-1]:
            decoded = layer(decoded, encoded)
        # Nothing reads what the last layer makes of the history.
        first, end = self.read.start, self.read.stop
        last = self.decoder[-1](decoded, encoded, slice(HISTORY + first, HISTORY + end))
        future = pad(self.projection(last), (0, 0, first, self.rows - end), value=math.nan)
        return future.reshape(len(history), FUTURE, OUTPUTS)

    def _embedded(self, history: Tensor, expected: Tensor) -> Rows:
        """Return the decoder's input: the history, and a placeholder for every row of states."""
        if self.uniform_motion:
            states = expected[:, FUTURE // self.rows - 1 :: FUTURE // self.rows]
            return self.decoder_embedding(torch.cat([history, pad(states, (0, RESIDUALS))], dim=1))
        # The convolution of the first placeholder reaches into the history, the others are fixed.
        first = self.decoder_embedding(pad(history, (0, 0, 0, 1)))
        return first, self.decoder_embedding.of_zeros(len(history), HISTORY + 1)


def sinusoids(length: int, width: int) -> Tensor:
    """Return the (length, width) positional encoding of Vaswani 2017, section 3.5."""
    place = torch.arange(length, dtype=torch.float32)[:, None]
    rate = torch.exp(torch.arange(0, width, 2, dtype=torch.float32) * (-math.log(1e4) / width))
    angles = place * rate
    return torch.stack([angles.sin(), angles.cos()], dim=2).flatten(1)
