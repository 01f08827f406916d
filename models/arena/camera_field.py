"""The smooth systematic error of the cameras' positions, a random field over the room."""

from dataclasses import dataclass

import numpy as np

from rallygap.models.ball.types import Floats

FEATURES = 64  # cosines per axis


@dataclass(frozen=True)
class CameraField:
    """An error of position that is a fixed function of the true position.

    Each axis is an independent Gaussian random field with zero mean and the squared exponential
    kernel, as a sum of random Fourier features (Rahimi 2007). It is the same whenever it is
    evaluated.
    """

    standard_deviation: float  # m, of a coordinate
    length: float  # m, distance after which the correlation is exp(-1/2)
    seed: int  # of the field

    def errors(self, positions: Floats) -> Floats:
        """Return the (T, 3) errors (m) at (T, 3) true positions (m)."""
        random = np.random.default_rng(self.seed)
        waves = random.standard_normal((3, FEATURES, 3)) / self.length
        phases = random.uniform(0.0, 2 * np.pi, (3, FEATURES))
        angles = np.einsum("td,amd->tam", positions, waves) + phases
        amplitude = self.standard_deviation * np.sqrt(2 / FEATURES)
        errors: Floats = amplitude * np.cos(angles).sum(axis=2)
        return errors
