"""Recurrent trajectory autoencoder: gated recurrent units encode the history row by row.

The GRU variant of the trajectory autoencoder of Toussaint et al. 2025, *Real time trajectory
prediction of a ping-pong ball using a GRU-TAE*: one gated recurrent unit reads the rows, a second
reads the first's states, and the second's last state is the code. Two dense layers decode the
trajectory from it.

Same as there: the layers, the ELU between the dense ones, and the mask as an input. Different: the
input is position and spin instead of position; the output is position, velocity and spin of the
future alone, where theirs reads a whole trajectory with zeros for its future and outputs all of it;
the units are torch's, whose candidates go through a hyperbolic tangent instead of an ELU.
"""

from torch import Tensor, nn
from torch.nn.functional import elu

from rallygap.models.predictors.normaliser import OUTPUTS
from rallygap.models.predictors.protocol import FUTURE
from rallygap.models.predictors.tae import input_rows, row_size


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
        future: Tensor = self.projection(elu(self.decoder(states[:, -1])))
        return future.reshape(len(history), FUTURE, OUTPUTS)
