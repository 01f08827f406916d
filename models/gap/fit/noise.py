"""Noise model: the sensor's errors, the scatter of bounces, and priors (docs/naming.md).

The slow error of a coordinate is an Ornstein-Uhlenbeck process. Outliers have their white variance
divided by the probability that they are none. Kicks at bounces are Gaussian of zero mean. States,
and spins without a label, have diffuse priors.
"""

from dataclasses import dataclass, fields, replace

import numpy as np
from numpy.typing import NDArray
from scipy.special import expit

from rallygap.models.ball import state
from rallygap.models.ball.types import Floats
from rallygap.models.gap.fit.linearize import Linearised
from rallygap.models.gap.fit.whitening import shrink_along, white_products
from rallygap.models.gap.settings import FitSettings

NO_WEIGHT = 1e-6
NORMAL_SPREAD = 1.4826  # standard deviation over median absolute deviation of a normal
# Standard deviations of a diffuse prior of states: m, m/s, rad/s, a component.
ANY_PLACE, ANY_SPEED, ANY_SPIN = 100.0, 1000.0, 1e4


@dataclass(frozen=True)
class Noise:
    """Standard deviations of all that is random.

    Attributes:
        white: of a coordinate, m.
        slow: of its slow error, m.
        slow_time: in which the slow error's correlation falls to 1/e, s.
        timing: of a time stamp, s.
        label: of a component of a label, as a share of the spin, independent in every row.
        label_arc: the same, common to all rows between two contacts.
        label_common: the same, common to all rows of a shot.
        scatter: of a bounce upwards, along the slip and across, as a share of the normal speed.
    """

    white: float = 0.003
    slow: float = 0.001
    slow_time: float = 0.05
    label: float = 0.05
    label_arc: float = 0.0
    label_common: float = 0.02
    scatter: tuple[float, float, float] = (0.02, 0.02, 0.02)
    timing: float = 1e-4

    @property
    def position(self) -> float:
        """Standard deviation of a coordinate, m, that of the time stamps aside."""
        return float(np.hypot(self.white, self.slow))

    @property
    def label_error(self) -> float:
        """Standard deviation of a component of a single label, as a share of the spin."""
        return float(np.sqrt(self.label**2 + self.label_arc**2 + self.label_common**2))

    def label_variance(self, in_arc: Floats, in_shot: Floats) -> Floats:
        """Return the variance that each label counts as, as if labels were independent.

        The arguments are the numbers of labels that share its errors, its own included.
        """
        variance: Floats = self.label**2 + in_arc * self.label_arc**2
        return variance + in_shot * self.label_common**2

    def timing_scale(self, velocities: Floats) -> Floats:
        """Return (...) the size of errors across (..., 3) velocities, in that of errors along."""
        squares = np.einsum("...i,...i->...", velocities, velocities)
        share: Floats = 1 / np.sqrt(1.0 + squares * (self.timing / self.white) ** 2)
        return share

    def whiten_timing(self, rows: Floats, velocities: Floats) -> Floats:
        """Return (B, N, 3, C) rows of positions shrunk along (B, N, 3) velocities.

        Their errors are then alike in all directions.
        """
        directions = np.ascontiguousarray(velocities)
        return shrink_along(
            np.ascontiguousarray(rows), directions, self.timing_reduction(velocities)
        )

    def timing_reduction(self, velocities: Floats) -> Floats:
        """Return (B, N) factors c: rows r become r - c v v' r, for (B, N, 3) velocities v."""
        squares = np.einsum("bni,bni->bn", velocities, velocities)
        timing_reduction: Floats = (1 - self.timing_scale(velocities)) / np.maximum(squares, 1e-12)
        return timing_reduction

    def scaled(self, factor: float) -> "Noise":
        """Return the noise with position errors multiplied by ``factor``."""
        return replace(self, white=factor * self.white, slow=factor * self.slow)


@dataclass(frozen=True)
class GramMatrices:
    """Gram matrices (B, C, C) of linearised shots, C = E + K + F + 1 columns.

    F is the number of shared errors, whose columns are zero in the matrices of labels.

    They are separate by what their scale depends on, so that all but the noise of positions can be
    changed at no cost.

    Attributes:
        positions: in the metric of the positions' noise.
        label_deviations: of labels less the mean of their arc, in units of the spin.
        label_means: (B, J, 3, C) columns of the mean label of every arc, zero where it has none.
        counts: (B, J) labels an arc.
        nuisance: (B, E) where the shots are linearised.
        shot_weights: (B,) the inverse of a factor on the variance of a shot's measurements.
    """

    positions: Floats
    label_deviations: Floats
    label_means: Floats
    counts: Floats
    nuisance: Floats
    shot_weights: Floats

    def __getitem__(self, rows: NDArray[np.int64]) -> "GramMatrices":
        """Return those of some of the shots."""
        return GramMatrices(*(getattr(self, field.name)[rows] for field in fields(self)))

    def transformed(self, kept: Floats) -> "GramMatrices":
        """Return those of (C', C) sums of the columns; the nuisance parameters stay first."""
        return replace(
            self,
            positions=kept @ self.positions @ kept.T,
            label_deviations=kept @ self.label_deviations @ kept.T,
            label_means=self.label_means @ kept.T,
        )

    def total(self, noise: Noise) -> Floats:
        """Return (B, C, C) in the metric of all noise, priors included as measurements."""
        gram = self.positions + self.label_deviations / noise.label**2 + self._of_means(noise)
        precision, nuisance_count = self.precision(noise), np.arange(self.nuisance.shape[1])
        gram[:, nuisance_count, nuisance_count] += precision
        pull = precision * self.nuisance
        pull[:, : state.STATE_SIZE] = 0.0
        gram[:, nuisance_count, -1] -= pull
        gram[:, -1, nuisance_count] -= pull
        gram[:, -1, -1] += (pull * self.nuisance).sum(axis=1)
        return gram * self.shot_weights[:, None, None]

    def precision(self, noise: Noise) -> Floats:
        """Return (B, E) the precision of each nuisance parameter's prior."""
        return prior_precision(
            self.counts.sum(axis=1) == 0, self.nuisance.shape[1], noise, ANY_SPIN
        )

    def label_determinants(self, noise: Noise) -> Floats:
        """Return (B,) logarithms of the determinants of labels' errors, in units of the spin."""
        n, white = self.counts, noise.label**2
        of_arcs = (n - 1) * np.log(white) + np.log(white + n * noise.label_arc**2)
        shared = np.log1p(noise.label_common**2 * self._mean_precision(noise).sum(axis=1))
        determinants: Floats = 3 * (np.where(n > 0, of_arcs, 0.0).sum(axis=1) + shared)
        return determinants

    def _mean_precision(self, noise: Noise) -> Floats:
        """Return (B, J) the precision of the mean label of an arc, errors of shots aside."""
        n = self.counts
        variance = noise.label_arc**2 + noise.label**2 / np.maximum(n, 1.0)
        return np.where(n > 0, 1 / variance, 0.0)

    def _of_means(self, noise: Noise) -> Floats:
        """Return (B, C, C) of the arcs' mean labels, whose common error is integrated out."""
        precision = self._mean_precision(noise)[..., None, None]
        common = noise.label_common**2
        total = (precision * self.label_means).sum(axis=1, keepdims=True)
        shrunk = common / (1 + common * precision.sum(axis=1, keepdims=True))
        of_means: Floats = gram(np.sqrt(precision) * self.label_means)
        return of_means - gram(np.sqrt(shrunk) * total)


def gram_matrices(
    linear: Linearised, noise: Noise, weights: Floats, shot_weights: Floats
) -> GramMatrices:
    """Return the Gram matrices of linearised shots.

    The (B, N) weights are probabilities that samples are no outliers, the (B,) shot weights 1 for a
    whole shot.
    """
    positions, _ = white_gram(linear.positions, linear, noise, weights)
    deviations, means, counts = _by_arc(linear)
    of_deviations = np.zeros_like(positions)
    all_means = np.zeros((*means.shape[:3], positions.shape[-1]))
    places = linear.of_labels
    of_deviations[:, places[:, None], places] = gram(deviations)
    all_means[..., places] = means
    return GramMatrices(positions, of_deviations, all_means, counts, linear.nuisance, shot_weights)


def _by_arc(linear: Linearised) -> tuple[Floats, Floats, Floats]:
    """Return labels less the means of their arcs, (B, J, 3, C) these means, (B, J) their counts."""
    member = (linear.labelled[..., None] & linear.in_arcs).astype(np.float64)
    counts, shape = member.sum(axis=1), linear.labels.shape
    rows = linear.labels.reshape(*shape[:2], shape[2] * shape[3])
    means = np.swapaxes(member, 1, 2) @ rows / np.maximum(counts, 1.0)[..., None]
    deviations = (rows - member @ means).reshape(shape)
    return deviations, means.reshape(*counts.shape, *shape[2:]), counts


def gram(rows: Floats) -> Floats:
    """Return (B, C, C) products of the columns of (B, N, 3, C) rows."""
    flat = rows.reshape(len(rows), -1, rows.shape[-1])
    return np.swapaxes(flat, 1, 2) @ flat


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
        noise.timing_reduction(linear.velocities),
        linear.shots.times,
        np.where(usable < NO_WEIGHT, 0.0, usable),
        (noise.white, noise.slow, noise.slow_time),
    )
    timing_scale = np.where(usable < NO_WEIGHT, 1.0, noise.timing_scale(linear.velocities))
    return products, determinants - 2 * np.log(timing_scale).sum(axis=1)


def prior_precision(unlabelled: NDArray[np.bool_], size: int, noise: Noise, spin: float) -> Floats:
    """Return (B, size) the precision of the prior of each shot's nuisance parameters.

    A component of a spin without a label has the standard deviation ``spin``, rad/s.
    """
    anything = np.repeat([ANY_PLACE, ANY_SPEED, ANY_SPIN], 3) ** -2.0
    precision = np.zeros((len(unlabelled), size))
    precision[:, : state.STATE_SIZE] = anything
    precision[unlabelled, state.SPIN] = spin**-2
    count_bounces = (size - state.STATE_SIZE) // 3
    precision[:, state.STATE_SIZE :] = np.tile(np.array(noise.scatter) ** -2.0, count_bounces)
    return precision


def inlier_probability(residuals: Floats, noise: Noise, settings: FitSettings) -> Floats:
    """Return (B, N) probabilities that (B, N, 3) whitened residuals are no outliers."""
    inlier, outlier = _log_densities(residuals, noise, settings)
    return expit(inlier - outlier)


def deviance(residuals: Floats, noise: Noise, settings: FitSettings) -> Floats:
    """Return (B, N) twice the negative log likelihoods of (B, N, 3) whitened residuals.

    The density is a mixture of two normals, of inliers and of outliers; constants are left out so
    that a residual of zero has a deviance of about zero.
    """
    return -2.0 * np.logaddexp(*_log_densities(residuals, noise, settings))


def _log_densities(residuals: Floats, noise: Noise, settings: FitSettings) -> tuple[Floats, Floats]:
    """Return logarithms of the densities of inliers and outliers, times the shares of both."""
    share, spread = settings.outlier_share, settings.outlier_spread
    ratio = min(noise.position / spread, settings.max_noise_to_outlier_spread)
    distance = (residuals**2).sum(axis=-1) / noise.position**2
    inlier = np.log(1 - share) - distance / 2
    return inlier, np.log(share * ratio**3) - distance * ratio**2 / 2
