"""Measurement errors of a camera system: random and systematic ones, dropouts and outliers."""

from dataclasses import dataclass

import numpy as np
from scipy.signal import lfilter

from rallygap.models.arena.camera_field import CameraField
from rallygap.models.ball.state import POSITION, SPIN
from rallygap.models.ball.types import Bools, Floats, Integers

OUTLIER_DISTANCE = (0.05, 0.30)  # m between the ball and a false detection


@dataclass(frozen=True)
class SlowError:
    """The part of the position error that changes slowly along a path (Ornstein-Uhlenbeck)."""

    share: float  # of the variance of the whole error
    time: float  # s after which the correlation is 1/e


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
        positions = self._distorted(states[:, POSITION])
        positions = positions + self.position_noise * self._errors(count, random)
        outlying = random.random(count) < self.outliers
        positions[outlying] += _offsets(int(outlying.sum()), random)
        size = np.linalg.norm(states[:, SPIN], axis=1, keepdims=True)
        spins = states[:, SPIN] + self.spin_noise * size * random.standard_normal((count, 3))
        if self.arc_spin_noise > 0.0:
            arcs = np.zeros(count, dtype=np.int64) if arcs is None else arcs
            spins += self.arc_spin_noise * size * _shared_errors(arcs, random)
        return positions, spins, random.random(count) >= self.dropouts

    def _distorted(self, positions: Floats) -> Floats:
        return positions if self.field is None else positions + self.field.errors(positions)

    def _errors(self, count: int, random: np.random.Generator) -> Floats:
        """Return (count, 3) errors of unit variance: white noise plus slow errors."""
        white, kicks = random.standard_normal((2, count, 3))
        memory = np.exp(-self.interval / self.slow_error.time)
        kicks[1:] *= np.sqrt(1 - memory**2)
        slow = lfilter([1.0], [1.0, -memory], kicks, axis=0)
        share = self.slow_error.share
        errors: Floats = np.sqrt(1 - share) * white + np.sqrt(share) * slow
        return errors


def _shared_errors(arcs: Integers, random: np.random.Generator) -> Floats:
    """Return (T, 3) errors of unit variance, the same for all rows of an arc."""
    numbers, rows = np.unique(arcs, return_inverse=True)
    errors: Floats = random.standard_normal((len(numbers), 3))[rows]
    return errors


def _offsets(count: int, random: np.random.Generator) -> Floats:
    """Return (count, 3) displacements in any direction."""
    directions = random.standard_normal((count, 3))
    directions /= np.linalg.norm(directions, axis=1, keepdims=True)
    offsets: Floats = directions * random.uniform(*OUTLIER_DISTANCE, size=(count, 1))
    return offsets
