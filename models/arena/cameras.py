"""Cameras: what a tracking system makes of a ball's true path."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from models.ball.state import POSITION, SPIN

Floats = NDArray[np.float64]

OUTLIER_DISTANCE = (0.05, 0.30)  # m between the ball and what is taken for it


@dataclass(frozen=True)
class Cameras:
    """A tracking system.

    Attributes:
        position_noise: standard deviation of a coordinate (m).
        spin_noise: standard deviation of a spin component, as a share of the spin.
        dropouts: share of the samples that are missed.
        outliers: share of the samples where something else is taken for the ball.
    """

    position_noise: float
    spin_noise: float
    dropouts: float
    outliers: float

    def measure(
        self, states: Floats, random: np.random.Generator
    ) -> tuple[Floats, Floats, NDArray[np.bool_]]:
        """Measure a path.

        Args:
            states: (T, 9) true states.
            random: where the noise comes from.

        Returns:
            Positions (T, 3), spins (T, 3) and which of the samples were seen (T,).
        """
        noise = random.standard_normal((len(states), 3))
        positions = states[:, POSITION] + self.position_noise * noise
        outlying = random.random(len(states)) < self.outliers
        positions[outlying] += _offsets(int(outlying.sum()), random)
        size = np.linalg.norm(states[:, SPIN], axis=1, keepdims=True)
        noise = random.standard_normal((len(states), 3))
        spins = states[:, SPIN] + self.spin_noise * size * noise
        return positions, spins, random.random(len(states)) >= self.dropouts


def _offsets(count: int, random: np.random.Generator) -> Floats:
    """Return (count, 3) displacements in any direction."""
    directions = random.standard_normal((count, 3))
    directions /= np.linalg.norm(directions, axis=1, keepdims=True)
    offsets: Floats = directions * random.uniform(*OUTLIER_DISTANCE, size=(count, 1))
    return offsets
