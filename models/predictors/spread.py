"""How sure a learned forecast is: a small network for the covariance of its position errors."""

import numpy as np
import torch
from torch import Tensor, nn

from rallygap.models.predictors.autoencoders import input_rows, row_size
from rallygap.models.predictors.protocol import FUTURE, HISTORY

WIDTH = 128
FACTORS = 6  # numbers in a (3, 3) lower triangle
_ROWS, _COLUMNS = np.tril_indices(3)


class Spread(nn.Module):
    """Maps a normalised history to factors of the covariance of the forecast's position error.

    The covariance is that of most errors: the scale of a Student-t distribution, whose tails (balls
    that hit the net) are wider. Its layers say how much larger errors are than ``sizes``, typical
    ones.
    """

    sizes: Tensor

    def __init__(self) -> None:
        super().__init__()
        self.register_buffer("sizes", torch.ones(FUTURE, 3))
        inputs = HISTORY * row_size(uniform_motion=True)
        self.layers = nn.Sequential(
            nn.Linear(inputs, WIDTH),
            nn.GELU(),
            nn.Linear(WIDTH, WIDTH),
            nn.GELU(),
            nn.Linear(WIDTH, FUTURE * FACTORS),
        )

    def forward(self, history: Tensor, mask: Tensor, residual: Tensor) -> Tensor:
        """Return (B, 60, 3, 3) lower triangles L, in the units of the normaliser.

        Args:
            history: (B, 12, 6) normalised measurements.
            mask: (B, 12, 6) where there are any.
            residual: (B, 12, 3) their deviations from the baseline's straight line.
        """
        inputs = input_rows(history, mask, residual, uniform_motion=True)
        values = self.layers(inputs.flatten(1)).view(-1, FUTURE, FACTORS)
        factors = values.new_zeros((*values.shape[:2], 3, 3))
        factors[..., _ROWS, _COLUMNS] = values
        diagonal = torch.diagonal(factors, dim1=2, dim2=3).exp()
        return self.sizes[..., None] * (factors.tril(-1) + torch.diag_embed(diagonal))
