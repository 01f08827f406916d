"""Trajectory autoencoder: dense layers encode the history and decode the whole forecast at once.

The network of Gomez-Gonzalez et al., *Real time trajectory prediction using deep conditional
generative models* (2020, arXiv 1909.03895): an encoder maps the measured trajectory and its mask to
a code; a decoder maps the same trajectory and mask, and the code, to the whole trajectory.

Same as there: the layers, their sizes and activations, and the mask as an input. Different: the
input is position and spin instead of position; the output is position, velocity and spin of the
future alone; the code is the encoder's mean without sampling, because all networks here are trained
with the same loss, which has no term for a variance; the encoder never sees the future, not even in
training.
"""

import torch
from torch import Tensor, nn
from torch.nn.functional import relu

from rallygap.models.predictors.normaliser import INPUTS, OUTPUTS, RESIDUALS
from rallygap.models.predictors.protocol import FUTURE, HISTORY


class DenseLayers(nn.Module):
    """Two dense layers on the whole history."""

    def __init__(self, inputs: int, hidden: int, features: int) -> None:
        super().__init__()
        self.projection, self.inner = nn.Linear(inputs, hidden), nn.Linear(hidden, features)

    def forward(self, flat: Tensor) -> Tensor:
        """Return (B, features) of (B, inputs)."""
        return relu(self.inner(relu(self.projection(flat))))


class TrajectoryAutoencoder(nn.Module):
    """The network, on normalised states; ``TaeSettings`` describes its arguments."""

    def __init__(
        self, hidden: int, features: int, latent: int, decoded: int, uniform_motion: bool
    ) -> None:
        super().__init__()
        self.uniform_motion = uniform_motion
        inputs = HISTORY * row_size(uniform_motion)
        self.encoder, self.decoder = (DenseLayers(inputs, hidden, features) for _ in range(2))
        self.code = nn.Linear(features, latent)
        self.joined = nn.Linear(features + latent, decoded)
        self.projection = nn.Linear(decoded, FUTURE * OUTPUTS)

    def forward(self, history: Tensor, mask: Tensor, residual: Tensor, expected: Tensor) -> Tensor:
        """Return (B, 60, 9) normalised deviations from the baseline (``ForecastNetwork``)."""
        flat = input_rows(history, mask, residual, self.uniform_motion).flatten(1)
        joined = torch.cat([self.decoder(flat), self.code(self.encoder(flat))], dim=1)
        future: Tensor = self.projection(relu(self.joined(joined)))
        return future.reshape(len(history), FUTURE, OUTPUTS)


def row_size(uniform_motion: bool) -> int:
    """Return the number of columns of ``input_rows``."""
    return 2 * INPUTS + RESIDUALS * uniform_motion


def input_rows(history: Tensor, mask: Tensor, residual: Tensor, uniform_motion: bool) -> Tensor:
    """Return (B, 12, row_size) measurements, mask and, if asked for, residuals side by side."""
    columns = [history, mask.to(history.dtype)]
    return torch.cat([*columns, residual] if uniform_motion else columns, dim=2)
