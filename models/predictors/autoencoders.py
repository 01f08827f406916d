"""Trajectory autoencoders: they encode the history and decode the whole forecast at once.

``TrajectoryAutoencoder`` is the network of Gomez-Gonzalez et al., *Real time trajectory prediction
using deep conditional generative models* (2020, arXiv 1909.03895): an encoder of dense layers maps
the measured trajectory and its mask to a code; a decoder maps the same trajectory and mask, and the
code, to the whole trajectory. ``RecurrentAutoencoder`` is the GRU variant of Toussaint et al. 2025,
*Real time trajectory prediction of a ping-pong ball using a GRU-TAE*: one gated recurrent unit
reads the rows, a second reads the first's states, and the second's last state is the code. Two
dense layers decode the trajectory from it.

Same as there: the layers, their sizes and activations, and the mask as an input. Different: the
input is position and spin instead of position; the output is position, velocity and spin of the
future alone, which the encoder never sees. The first network's code is the encoder's mean without
sampling, because all networks here are trained with the same loss, which has no term for a
variance. The second's units are torch's, whose candidates go through a hyperbolic tangent instead
of an ELU.
"""

import torch
from torch import Tensor, nn
from torch.nn.functional import elu, relu

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
        future = self.projection(relu(self.joined(joined)))
        return future.reshape(len(history), FUTURE, OUTPUTS)


class RecurrentUnit(nn.Module):
    """A gated recurrent unit (Cho 2014) over rows.

    Its matrices stack three gates each, so Muon must not orthogonalise them; the name
    ``projections`` leaves them to Adam.
    """

    def __init__(self, inputs: int, width: int) -> None:
        super().__init__()
        self.projections = nn.GRU(inputs, width, batch_first=True)

    def forward(self, rows: Tensor) -> Tensor:
        """Return the state after each of (B, T, inputs) rows, (B, T, width)."""
        return self.projections(rows)[0]


class RecurrentAutoencoder(nn.Module):
    """The network, on normalised states; ``GruTaeSettings`` describes its arguments."""

    def __init__(self, recurrent: int, latent: int, decoded: int, uniform_motion: bool) -> None:
        super().__init__()
        self.uniform_motion = uniform_motion
        self.encoder = nn.Sequential(
            RecurrentUnit(row_size(uniform_motion), recurrent), RecurrentUnit(recurrent, latent)
        )
        self.decoder = nn.Linear(latent, decoded)
        self.projection = nn.Linear(decoded, FUTURE * OUTPUTS)

    def forward(self, history: Tensor, mask: Tensor, residual: Tensor, expected: Tensor) -> Tensor:
        """Return (B, 60, 9) normalised deviations from the baseline (``ForecastNetwork``)."""
        states = self.encoder(input_rows(history, mask, residual, self.uniform_motion))
        future = self.projection(elu(self.decoder(states[:, -1])))
        return future.reshape(len(history), FUTURE, OUTPUTS)


def row_size(uniform_motion: bool) -> int:
    """Return the number of columns of ``input_rows``."""
    return 2 * INPUTS + RESIDUALS * uniform_motion


def input_rows(history: Tensor, mask: Tensor, residual: Tensor, uniform_motion: bool) -> Tensor:
    """Return (B, 12, row_size) measurements, mask and, if asked for, residuals side by side."""
    columns = [history, mask.to(history.dtype)]
    return torch.cat([*columns, residual] if uniform_motion else columns, dim=2)
