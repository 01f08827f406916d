"""Discrepancy of predictions whose launch is fitted to the first samples and labels of a shot.

A departure F from the simulator shifts the fitted launch as well: near fitted shots (linearize.py)

    discrepancy of F = F - G (G'WG)^-1 G'WF,    the products over the first samples alone,

with G the columns of the launch. Spins without a label are held at those of the whole path.
"""

import numpy as np

from rallygap.models.ball.state import STATE_SIZE
from rallygap.models.ball.types import Floats
from rallygap.models.gap.fit.horizons import last_observed_time
from rallygap.models.gap.fit.linearize import Linearised, label_counts
from rallygap.models.gap.fit.noise import prior_precision
from rallygap.models.gap.fit.variance_components import NoiseEstimate
from rallygap.models.gap.settings import GapSettings
from rallygap.models.gap.types import Bools


def discrepancy(
    linear: Linearised,
    noise: NoiseEstimate,
    positions: Floats,
    labels: Floats,
    settings: GapSettings,
) -> Floats:
    """Return (B, N, 3, D) discrepancies of predictions that D changes cause.

    Args:
        linear: shots, whose columns of the launch come first.
        noise: in which launches are fitted.
        positions: (B, N, 3, D) changes of positions, m.
        labels: (B, L, 3, D) changes of spin labels, in units of the fitted spin.
        settings: of predictions.
    """
    launch, spins = linear.positions[..., :STATE_SIZE], linear.labels[..., :STATE_SIZE]
    sizes = noise.noise
    first = linear.sampled & (np.arange(launch.shape[1]) < settings.observed_samples)
    early = first * noise.weights / sizes.position**2
    labelled = linear.labelled & (
        linear.shots.label_times <= last_observed_time(linear.shots, settings)
    )
    label_weights = labelled / sizes.label_variance(*label_counts(labelled, linear.label_arcs))
    unlabelled = ~np.asarray(labelled.any(axis=1))
    prior = prior_precision(unlabelled, STATE_SIZE, sizes, settings.locate.known_spin)
    normal = _products(launch, early, launch) + _products(spins, label_weights, spins)
    normal += prior[..., None] * np.eye(STATE_SIZE)
    pull = _products(launch, early, positions) + _products(spins, label_weights, labels)
    return positions - launch @ np.linalg.solve(normal, pull)[:, None]


def reliable(linear: Linearised, noise: NoiseEstimate, settings: GapSettings) -> Bools:
    """Return (B, N) which samples are used and no outliers, of shots with enough weight."""
    weighty = noise.shot_weights[:, None] > settings.locate.min_shot_weight
    return linear.sampled & (noise.weights > settings.locate.min_inlier) & weighty


def _products(left: Floats, weights: Floats, right: Floats) -> Floats:
    """Return (B, E, D) sums of weighted products of (B, N, 3, E) and (B, N, 3, D)."""
    count = len(left)
    weighted = (left * weights[..., None, None]).reshape(count, -1, left.shape[-1])
    return np.swapaxes(weighted, 1, 2) @ right.reshape(count, -1, right.shape[-1])
