"""Noise: what the sensor adds, how bounces scatter, and what is known of spins beforehand.

- A coordinate errs by white noise plus an error that changes slowly, an Ornstein-Uhlenbeck process
  (``slow`` m, correlation falls to 1/e in ``slow_time`` s). Outliers have their white variance
  divided by the probability that they are none.
- A component of a spin label errs by ``label`` times the spin in every row, and by ``label_common``
  times the spin in all rows of a shot alike.
- Kicks at bounces (motion.py) are Gaussian of zero mean, with a size each way.
- States have hardly any prior, spins without a label neither. Lift is a product of spin and C_M, so
  a prior that pulls all spins to zero would pull C_M up, and a mean spin that is not zero would
  pass for gravity.

``Grams`` keeps the whitened Gram matrices apart by what their scale depends on, so that all but the
positions' noise can be changed at no cost.
"""

from dataclasses import dataclass, fields, replace

import numpy as np
from numpy.typing import NDArray
from scipy.special import expit

from models.ball import state
from models.ball.types import Floats
from models.gap.fit.linearize import Linearised
from models.gap.fit.whitening import shrunk, white_products

OUTLIERS = 0.02  # share of outliers expected
OUTLIER_SIZE = 0.1  # m, their spread
LARGEST_NOISE = 0.3  # of the spread of outliers; beyond, outliers spread more
NO_WEIGHT = 1e-6
# A state may be anything up to these: m, m/s, rad/s, a component.
ANY_PLACE, ANY_SPEED, ANY_SPIN = 100.0, 1000.0, 1e4


@dataclass(frozen=True)
class Noise:
    """Sizes of all that is random.

    Attributes:
        white: of a coordinate, m.
        slow: of its slow error, m.
        slow_time: in which the slow error's correlation falls to 1/e, s.
        timing: of a time stamp, s.
        label: of a component of a label, as a share of the spin, in every row by itself.
        label_common: the same for all rows of a shot.
        scatter: of a bounce upwards, along the slip and across, as a share of the normal speed.
    """

    white: float = 0.003
    slow: float = 0.001
    slow_time: float = 0.05
    label: float = 0.05
    label_common: float = 0.02
    scatter: tuple[float, float, float] = (0.02, 0.02, 0.02)
    timing: float = 1e-4

    @property
    def position(self) -> float:
        """Standard deviation of a coordinate, m, that of the time stamps aside."""
        return float(np.hypot(self.white, self.slow))

    def steady(self, velocities: Floats) -> Floats:
        """Return (...) the size of errors across (..., 3) velocities, in that of errors along."""
        squares = np.einsum("...i,...i->...", velocities, velocities)
        share: Floats = 1 / np.sqrt(1.0 + squares * (self.timing / self.white) ** 2)
        return share

    def steadied(self, rows: Floats, velocities: Floats) -> Floats:
        """Return (B, N, 3, C) rows of positions shrunk along (B, N, 3) velocities.

        Their errors are then alike in all directions.
        """
        directions = np.ascontiguousarray(velocities)
        return shrunk(np.ascontiguousarray(rows), directions, self.less(velocities))

    def less(self, velocities: Floats) -> Floats:
        """Return (B, N) by how much times v v' rows shrink along (B, N, 3) velocities v."""
        squares = np.einsum("bni,bni->bn", velocities, velocities)
        less: Floats = (1 - self.steady(velocities)) / np.maximum(squares, 1e-12)
        return less

    def widened(self, factor: float) -> "Noise":
        """Return noise whose positions err by so many times as much."""
        return replace(self, white=factor * self.white, slow=factor * self.slow)


@dataclass(frozen=True)
class Grams:
    """Gram matrices (B, C, C) of linearised shots, C = E + K + 1 columns.

    Attributes:
        positions: in the metric of the positions' noise.
        apart: of labels less their mean, in units of the spin.
        mean: of the labels' mean, times their number.
        counts: (B,) labels a shot.
        unknowns: (B, E) where the shots are linearised.
        trust: (B,) in whole shots: the inverse of a factor on the variance of all that they say.
    """

    positions: Floats
    apart: Floats
    mean: Floats
    counts: Floats
    unknowns: Floats
    trust: Floats

    def __getitem__(self, rows: NDArray[np.int64]) -> "Grams":
        """Return those of some of the shots."""
        return Grams(*(getattr(self, field.name)[rows] for field in fields(self)))

    def total(self, noise: Noise) -> Floats:
        """Return (B, C, C) in the metric of all noise, priors included as measurements."""
        common = noise.label**2 + self.counts * noise.label_common**2
        gram = self.positions + self.apart / noise.label**2 + self.mean / common[:, None, None]
        precision, own = self.precision(noise), np.arange(self.unknowns.shape[1])
        gram[:, own, own] += precision
        pull = precision * self.unknowns
        pull[:, : state.STATE_SIZE] = 0.0
        gram[:, own, -1] -= pull
        gram[:, -1, own] -= pull
        gram[:, -1, -1] += (pull * self.unknowns).sum(axis=1)
        return gram * self.trust[:, None, None]

    def precision(self, noise: Noise) -> Floats:
        """Return (B, E) the precision of each unknown's prior."""
        return prior_precision(self.counts == 0, self.unknowns.shape[1], noise, ANY_SPIN)

    def label_determinants(self, noise: Noise) -> Floats:
        """Return (B,) logarithms of the determinants of labels' errors, in units of the spin."""
        n = self.counts
        common = np.log(noise.label**2 + n * noise.label_common**2)
        determinants = 3 * ((n - 1) * np.log(noise.label**2) + common)
        return np.where(n > 0, determinants, 0.0)


def grams(linear: Linearised, noise: Noise, weights: Floats, trust: Floats) -> Grams:
    """Return the Gram matrices of linearised shots.

    Args:
        linear: the shots.
        noise: of which the positions' part counts.
        weights: (B, N) probabilities that samples are no outliers.
        trust: (B,) in whole shots.
    """
    positions, _ = white_gram(linear.positions, linear, noise, weights)
    labels = linear.labels
    counts = linear.labelled.sum(axis=1).astype(np.float64)
    mean = labels.sum(axis=1, keepdims=True) / np.maximum(counts, 1.0)[:, None, None, None]
    apart = np.where(linear.labelled[..., None, None], labels - mean, 0.0)
    return Grams(
        positions,
        gram(apart),
        gram(mean) * counts[:, None, None],
        counts,
        linear.unknowns,
        trust,
    )


def gram(rows: Floats) -> Floats:
    """Return (B, C, C) products of the columns of (B, N, 3, C) rows."""
    flat = rows.reshape(len(rows), -1, rows.shape[-1])
    products: Floats = np.swapaxes(flat, 1, 2) @ flat
    return products


def white_gram(
    rows: Floats, linear: Linearised, noise: Noise, weights: Floats
) -> tuple[Floats, Floats]:
    """Return (B, C, C) products of the columns of (B, N, 3, C) rows, white in their noise.

    The innovations of a Kalman filter that follows the slow error are white. Second come the (B,)
    logarithms of the noise's determinants.
    """
    usable = np.where(linear.sampled, weights, 0.0)
    products, determinants = white_products(
        np.ascontiguousarray(rows),
        np.ascontiguousarray(linear.velocities),
        noise.less(linear.velocities),
        linear.shots.times,
        np.where(usable < NO_WEIGHT, 0.0, usable),
        (noise.white, noise.slow, noise.slow_time),
    )
    steady = np.where(usable < NO_WEIGHT, 1.0, noise.steady(linear.velocities))
    return products, determinants - 2 * np.log(steady).sum(axis=1)


def prior_precision(unlabelled: NDArray[np.bool_], size: int, noise: Noise, spin: float) -> Floats:
    """Return (B, size) the precision of the prior of each shot's unknowns.

    Args:
        unlabelled: (B,) whether a shot has no spin label.
        size: number of unknowns.
        noise: with the size of kicks.
        spin: size of a component of a spin without a label, rad/s.
    """
    anything = np.repeat([ANY_PLACE, ANY_SPEED, ANY_SPIN], 3) ** -2.0
    precision = np.zeros((len(unlabelled), size))
    precision[:, : state.STATE_SIZE] = anything
    precision[unlabelled, state.SPIN] = spin**-2
    bounces = (size - state.STATE_SIZE) // 3
    precision[:, state.STATE_SIZE :] = np.tile(np.array(noise.scatter) ** -2.0, bounces)
    return precision


def inlier_probability(residuals: Floats, noise: Noise) -> Floats:
    """Return (B, N) probabilities that (B, N, 3) residuals, steadied, are no outliers'."""
    inlier, outlier = _log_densities(residuals, noise)
    probability: Floats = expit(inlier - outlier)
    return probability


def surprise(residuals: Floats, noise: Noise) -> Floats:
    """Return (B, N) twice the negative log likelihoods of (B, N, 3) residuals, steadied.

    Outliers cost no more than they do; a residual of zero costs about nothing.
    """
    surprises: Floats = -2.0 * np.logaddexp(*_log_densities(residuals, noise))
    return surprises


def _log_densities(residuals: Floats, noise: Noise) -> tuple[Floats, Floats]:
    """Return logarithms of the densities of inliers and outliers, times the shares of both."""
    ratio = min(noise.position / OUTLIER_SIZE, LARGEST_NOISE)
    distance = (residuals**2).sum(axis=-1) / noise.position**2
    inlier = np.log(1 - OUTLIERS) - distance / 2
    return inlier, np.log(OUTLIERS * ratio**3) - distance * ratio**2 / 2
