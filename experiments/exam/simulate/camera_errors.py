"""Errors of the sensor beyond white and slow noise: shared by rows, arcs, shots or the session.

They act on exact measurements. Without errors of a kind nothing is drawn, so recordings of other
trials do not depend on them.
"""

from dataclasses import dataclass
from typing import Literal

import numpy as np

from rallygap.models.arena.bounce_scatter import BounceScatter
from rallygap.models.ball.simulator import Simulator
from rallygap.models.ball.types import Bools, Floats, Integers

FieldShape = Literal["gaussian", "radial", "half"]

FEATURES = 500  # random Fourier features of a Gaussian field
LENS_AXIS = np.array([0.0, 0.0, 0.5])  # m, where a radial distortion vanishes


@dataclass(frozen=True)
class LabelErrors:
    """Errors that spin labels share: standard deviations of a component, as a share of the spin.

    Errors of single rows are those of ``Cameras``; with an error of arcs there are none.
    """

    arc: float = 0.0  # of the one label of an arc, which all its rows repeat; 0: rows differ
    shot: float = 0.0  # the same in all rows of a shot
    session: float = 0.0  # the same in all rows of all shots

    def added(self, labels: Floats, arcs: Integers, random: np.random.Generator) -> Floats:
        """Return (B, T, 3) labels with these errors, from exact ones in rad/s.

        Args:
            labels: of a session.
            arcs: (B, T) number of bounces before each row.
            random: of the errors.
        """
        session = self.session * random.standard_normal(3)
        with_errors = []
        for shot_labels, shot_arcs in zip(labels, arcs, strict=True):
            shift = session + self.shot * random.standard_normal(3)
            rows, member = shot_labels, np.arange(len(shot_labels))
            if self.arc:
                _, first, member = np.unique(shot_arcs, return_index=True, return_inverse=True)
                rows = shot_labels[first]
                shift = shift + self.arc * random.standard_normal(rows.shape)
            sizes = np.linalg.norm(rows, axis=-1, keepdims=True)
            with_errors.append((rows + shift * sizes)[member])
        return np.array(with_errors)


@dataclass(frozen=True)
class Distortion:
    """A smooth position error that depends on the place only and is the same in all shots.

    - ``gaussian``: a Gaussian random field with squared exponential correlation.
    - ``radial``: grows with the cube of the distance from an axis point, as of a lens.
    - ``half``: a false tilt and scale of the half y > 0, zero at the net.
    """

    shape: FieldShape
    size: float  # standard deviation of a coordinate over the recorded places, m
    length: float = 1.0  # correlation length, m; the other shapes are about as smooth as 1 m

    def errors(self, positions: Floats, random: np.random.Generator) -> Floats:
        """Return (..., 3) errors in m at (..., 3) positions of one session."""
        if self.shape == "gaussian":  # random Fourier features, of unit variance
            waves = random.standard_normal((3, FEATURES))
            phases = random.uniform(0.0, 2.0 * np.pi, FEATURES)
            weights = random.standard_normal((FEATURES, 3))
            angles = (positions / self.length) @ waves + phases
            return self.size * (np.sqrt(2.0 / FEATURES) * np.cos(angles) @ weights)
        if self.shape == "radial":
            away = positions - LENS_AXIS
            errors = random.choice([-1.0, 1.0]) * (away**2).sum(axis=-1, keepdims=True) * away
        else:
            errors = np.maximum(positions[..., 1:2], 0.0) * random.standard_normal(3)
        return self.size / np.sqrt((errors**2).mean()) * errors


@dataclass(frozen=True)
class Stamps:
    """Errors of time stamps, s. Rows whose stamp is no later than an earlier one are lost."""

    rounding: float = 0.0  # to multiples of it
    jitter: float = 0.0  # to either side, uniform

    @property
    def deviation(self) -> float:
        """Standard deviation, s."""
        return float(np.hypot(self.rounding / np.sqrt(12.0), self.jitter / np.sqrt(3.0)))

    def stamped(self, times: Floats, random: np.random.Generator) -> Floats:
        """Return (T,) stamps of frames at (T,) times."""
        stamps = times + self.jitter * random.uniform(-1.0, 1.0, len(times))
        return np.round(stamps / self.rounding) * self.rounding if self.rounding else stamps


@dataclass(frozen=True)
class CameraErrors:
    """All of these errors; the default has none."""

    labels: LabelErrors = LabelErrors()
    distortion: Distortion | None = None
    stamps: Stamps = Stamps()
    # degrees of freedom of the t distribution of a row's whole position error; None: normal
    tails: float | None = None


@dataclass(frozen=True)
class HeavyTailedScatter(BounceScatter):
    """Bounce scatter with t distributions of the same standard deviations."""

    degrees: float = 3.0

    def apply(
        self, simulator: Simulator, before: Floats, after: Floats, random: np.random.Generator
    ) -> Floats:
        """Return the (B, 9) states just after bounces, as ``BounceScatter`` does."""
        scattered = after.copy()
        for ball, factor in enumerate(tail_factors(len(before), self.degrees, random)):
            scatter = BounceScatter(factor * self.restitution, factor * self.friction)
            here = slice(ball, ball + 1)
            scattered[here] = scatter.apply(simulator, before[here], after[here], random)
        return scattered


def tail_factors(count: int, degrees: float, random: np.random.Generator) -> Floats:
    """Return (count,) factors that turn normal errors into errors of a t distribution.

    Their mean square is one, so standard deviations stay the same.
    """
    return np.sqrt((degrees - 2.0) / random.chisquare(degrees, count))


def rising(stamps: Floats, kept: Bools) -> Bools:
    """Return which of (T,) kept rows have a stamp later than all kept rows before."""
    before = np.maximum.accumulate(np.where(kept, stamps, -np.inf))
    later = stamps > np.concatenate([[-np.inf], before[:-1]])
    return np.logical_and(kept, later)
