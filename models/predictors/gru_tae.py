"""A recurrent trajectory autoencoder: what was seen, read row by row into a code, told from it.

The GRU variant of the trajectory autoencoder of Toussaint et al. 2025, *Real time trajectory
prediction of a ping-pong ball using a GRU-TAE*: one gated recurrent unit reads the rows, a second
reads the first's states, and the state in which the second ends is the code. Two dense layers tell
the trajectory from it.

Taken: the layers, the ELU between the dense ones, the mask beside the input. Changed: position and
spin go in instead of position; position, velocity and spin come out, of the future alone, where
theirs reads a whole trajectory with zeros for its future, and tells all of it; the units are
torch's, whose candidates go through a hyperbolic tangent instead of an ELU.
"""

from torch import Tensor, nn
from torch.nn.functional import elu

from models.predictors.normaliser import OUTPUTS
from models.predictors.protocol import FUTURE
from models.predictors.tae import row_numbers, rows


class RecurrentUnit(nn.Module):
    """A gated recurrent unit (Cho 2014) over rows.

    Its matrices are called projections, because each is three gates one below the other: no one
    matrix that an optimizer could turn as such.
    """

    def __init__(self, inputs: int, width: int) -> None:
        super().__init__()
        self.projections = nn.GRU(inputs, width, batch_first=True)

    def forward(self, read: Tensor) -> Tensor:
        """Return what it holds after each of (B, T, inputs) rows, (B, T, width)."""
        held: Tensor = self.projections(read)[0]
        return held


class RecurrentAutoencoder(nn.Module):
    """The predictor's network, on normalised states.

    Args:
        recurrent: width of the first recurrent unit.
        latent: width of the second, numbers of the code.
        decoded: width of the dense layer.
        uniform_motion: whether it is told how far each measurement is off the ball's uniform
            motion.
    """

    def __init__(self, recurrent: int, latent: int, decoded: int, uniform_motion: bool) -> None:
        super().__init__()
        self.uniform_motion = uniform_motion
        self.encoder = nn.Sequential(
            RecurrentUnit(row_numbers(uniform_motion), recurrent), RecurrentUnit(recurrent, latent)
        )
        self.decoder = nn.Linear(latent, decoded)
        self.projection = nn.Linear(decoded, FUTURE * OUTPUTS)

    def forward(self, history: Tensor, seen: Tensor, residual: Tensor, expected: Tensor) -> Tensor:
        """Return (B, 60, 9) normalised future states.

        Args:
            history: (B, 12, 6) normalised measurements, zero where there are none.
            seen: (B, 12, 6) where there are.
            residual: (B, 12, 3) how far they are off uniform motion.
            expected: (B, 60, 6) normalised uniform motion, which it does not read.
        """
        held = self.encoder(rows(history, seen, residual, self.uniform_motion))
        future: Tensor = self.projection(elu(self.decoder(held[:, -1])))
        return future.reshape(len(history), FUTURE, OUTPUTS)
