"""Measurement errors of a camera system: random and systematic ones, dropouts and outliers."""

from dataclasses import dataclass

import numpy as np
from scipy.signal import lfilter

from rallygap.models.ball.state import POSITION, SPIN
from rallygap.models.ball.types import Bools, Floats, Integers

OUTLIER_DISTANCE = (0.05, 0.30)  # m between the ball and a false detection
FEATURES = 64  # cosines of a random field, per axis


@dataclass(frozen=True)
class SlowError:
    """The part of the position error that changes slowly along a path (Ornstein-Uhlenbeck)."""

    share: float  # of the variance of the whole error
    time: float  # s after which the correlation is 1/e


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
        return amplitude * np.cos(angles).sum(axis=2)


@dataclass(frozen=True)
class Cameras:
    """A tracking system."""

    position_noise: float  # standard deviation of a coordinate (m), the slow part included
    spin_noise: float  # standard deviation of a spin component, as a share of the spin
    dropouts: float  # share of missing samples
    outliers: float  # share of samples with a false detection
    slow_error: SlowError
    interval: float  # s between two samples
    field: CameraField | None = None  # systematic error of position, if any
    arc_spin_noise: float = 0.0  # as ``spin_noise``, of an error that all rows of an arc share

    def measure(
        self, states: Floats, random: np.random.Generator, arcs: Integers | None = None
    ) -> tuple[Floats, Floats, Bools]:
        """Measure a path.

        Args:
            states: (T, 9) true states, ``interval`` apart.
            random: of the errors, other than those of the field.
            arcs: (T,) number of each state's arc between two contacts; all on one arc if not given.

        Returns:
            Positions (T, 3), spins (T, 3) and whether each sample exists (T,).
        """
        count = len(states)
        positions = states[:, POSITION]
        if self.field is not None:
            positions = positions + self.field.errors(positions)
        positions = positions + self.position_noise * self._errors(count, random)
        outlying = random.random(count) < self.outliers
        away = random.standard_normal((int(outlying.sum()), 3))  # in any direction
        away /= np.linalg.norm(away, axis=1, keepdims=True)
        positions[outlying] += away * random.uniform(*OUTLIER_DISTANCE, size=(len(away), 1))
        size = np.linalg.norm(states[:, SPIN], axis=1, keepdims=True)
        spins = states[:, SPIN] + self.spin_noise * size * random.standard_normal((count, 3))
        if self.arc_spin_noise > 0.0:
            arcs = np.zeros(count, dtype=np.int64) if arcs is None else arcs
            numbers, rows = np.unique(arcs, return_inverse=True)
            shared = random.standard_normal((len(numbers), 3))[rows]
            spins += self.arc_spin_noise * size * shared
        return positions, spins, random.random(count) >= self.dropouts

    def _errors(self, count: int, random: np.random.Generator) -> Floats:
        """Return (count, 3) errors of unit variance: white noise plus slow errors."""
        white, kicks = random.standard_normal((2, count, 3))
        memory = np.exp(-self.interval / self.slow_error.time)
        kicks[1:] *= np.sqrt(1 - memory**2)
        slow = lfilter([1.0], [1.0, -memory], kicks, axis=0)
        share = self.slow_error.share
        return np.sqrt(1 - share) * white + np.sqrt(share) * slow
