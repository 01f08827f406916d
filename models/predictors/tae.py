"""A trajectory autoencoder: what was seen, squeezed into a code and told beside it once more.

The network of Gomez-Gonzalez et al., *Real time trajectory prediction using deep conditional
generative models* (2020, arXiv 1909.03895): an encoder maps the trajectory seen and its mask to a
code, a decoder maps the same trajectory and mask, and the code, to all of the trajectory at once.

Taken: the layers, their sizes and activations, the mask beside the input. Changed: position and
spin go in instead of position; position, velocity and spin come out, of the future alone; the code
is the mean that the encoder gives and no draw around it, because all networks learn by the same
loss, which has no term that would hold a draw's spread; the encoder never sees the future, in
training neither.
"""

import torch
from torch import Tensor, nn
from torch.nn.functional import relu

from models.predictors.normaliser import INPUTS, OUTPUTS, RESIDUALS
from models.predictors.protocol import FUTURE, HISTORY


class Reading(nn.Module):
    """Two dense layers over all that was seen."""

    def __init__(self, inputs: int, hidden: int, features: int) -> None:
        super().__init__()
        self.projection, self.inner = nn.Linear(inputs, hidden), nn.Linear(hidden, features)

    def forward(self, read: Tensor) -> Tensor:
        """Return (B, features) of (B, inputs)."""
        return relu(self.inner(relu(self.projection(read))))


class TrajectoryAutoencoder(nn.Module):
    """The predictor's network, on normalised states.

    Args:
        hidden: width of the first layer, of encoder and decoder alike.
        features: width of the second.
        latent: numbers of the code.
        decoded: width of the layer that joins code and features.
        uniform_motion: whether it is told how far each measurement is off the ball's uniform
            motion.
    """

    def __init__(
        self, hidden: int, features: int, latent: int, decoded: int, uniform_motion: bool
    ) -> None:
        super().__init__()
        self.uniform_motion = uniform_motion
        inputs = HISTORY * row_numbers(uniform_motion)
        self.encoder, self.decoder = (Reading(inputs, hidden, features) for _ in range(2))
        self.code = nn.Linear(features, latent)
        self.joined = nn.Linear(features + latent, decoded)
        self.projection = nn.Linear(decoded, FUTURE * OUTPUTS)

    def forward(self, history: Tensor, seen: Tensor, residual: Tensor, expected: Tensor) -> Tensor:
        """Return (B, 60, 9) normalised future states.

        Args:
            history: (B, 12, 6) normalised measurements, zero where there are none.
            seen: (B, 12, 6) where there are.
            residual: (B, 12, 3) how far they are off uniform motion.
            expected: (B, 60, 6) normalised uniform motion, which it does not read.
        """
        read = rows(history, seen, residual, self.uniform_motion).flatten(1)
        joined = torch.cat([self.decoder(read), self.code(self.encoder(read))], dim=1)
        future: Tensor = self.projection(relu(self.joined(joined)))
        return future.reshape(len(history), FUTURE, OUTPUTS)


def row_numbers(uniform_motion: bool) -> int:
    """Return how many numbers a row of ``rows`` has."""
    return 2 * INPUTS + RESIDUALS * uniform_motion


def rows(history: Tensor, seen: Tensor, residual: Tensor, uniform_motion: bool) -> Tensor:
    """Return (B, 12, row_numbers) measurements beside their mask, and beside their residuals."""
    told = [history, seen.to(history.dtype)]
    return torch.cat([*told, residual] if uniform_motion else told, dim=2)
