"""Spins by paths: what the path of a shot tells about the spin that its label measures.

A shot is fitted without its labels from the spin as it was fitted, and where it then fits far worse
than most from the negative of that spin too. The linearised fit gives mean and covariance of the
spin at the label, all other nuisance parameters eliminated. The prior is that of a spin of typical
size in any direction, so that a path that tells nothing decides nothing.
"""

from dataclasses import dataclass, replace

import numpy as np

from rallygap.models.ball.state import SPIN
from rallygap.models.ball.types import Floats
from rallygap.models.gap.fit.linearize import Linearised, linearise
from rallygap.models.gap.fit.noise import gram_matrices, prior_precision
from rallygap.models.gap.fit.refit import RefitResult
from rallygap.models.gap.fit.shot_fit import ShotFit, refit_shots
from rallygap.models.gap.fit.shots import Shots
from rallygap.models.gap.settings import FitSettings
from rallygap.models.gap.types import Bools, Indices


@dataclass(frozen=True)
class PathSpins:
    """Labels of S shots, and the spins that their paths tell.

    Attributes:
        rows: (S,) numbers of the shots.
        labels: (S, 3) rad/s, means of the labels in the first arc that has any.
        spins: (S, 3) rad/s, means of the spins at these labels.
        covariance: (S, 3, 3) of the spins.
    """

    rows: Indices
    labels: Floats
    spins: Floats
    covariance: Floats

    @classmethod
    def of(cls, shots: Shots, fit: RefitResult, settings: FitSettings) -> "PathSpins":
        """Return labels and spins of the labelled ones of the shots that were fitted."""
        rows = np.flatnonzero(shots.labelled.any(axis=1))
        some = shots.corrected(fit.camera_errors).without_shared()[rows]
        prior = _typical_component(some)
        found = _fitted_without_labels(some, fit, fit.linear.nuisance[rows], prior, settings)
        linear = linearise(some, fit.simulator, found.nuisance, ())
        used = _in_first_arc(linear)
        weights = used / np.maximum(used.sum(axis=1, keepdims=True), 1)
        columns = np.einsum("sl,slic->sic", weights * linear.label_scales, linear.labels)
        labels = np.einsum("sl,sli->si", weights, np.nan_to_num(some.labels))
        step, covariance = _posterior(linear, found, prior)
        slopes = columns[..., :-1]
        spins = labels - columns[..., -1] + np.einsum("sie,se->si", slopes, step)
        known = used.any(axis=1)
        spread = slopes @ covariance @ np.swapaxes(slopes, 1, 2)
        return cls(rows[known], labels[known], spins[known], spread[known])


def _typical_component(shots: Shots) -> float:
    """Return the typical size of a component of the labels, rad/s."""
    sizes = np.linalg.norm(shots.labels[shots.labelled], axis=1)
    return float(max(np.median(sizes) / np.sqrt(3.0), 1.0))


def _fitted_without_labels(
    shots: Shots, fit: RefitResult, nuisance: Floats, prior: float, settings: FitSettings
) -> ShotFit:
    """Return shots fitted without labels; those that fit far worse than most try another start.

    It has the negative of the spin: a wrong label may have led to a wrong minimum.
    """
    alone = replace(shots, label_times=np.full_like(shots.label_times, np.nan))
    noise, simulator = fit.noise_estimate.noise, fit.simulator
    found = refit_shots(alone, simulator, nuisance, noise, settings, spin=prior)
    far = np.flatnonzero(found.cost > settings.far_worse * np.median(found.cost))
    if not len(far):
        return found
    mirrored = nuisance[far]
    mirrored[:, SPIN] *= -1.0
    other = refit_shots(alone[far], simulator, mirrored, noise, settings, spin=prior)
    return found.with_better(far, other)


def _in_first_arc(linear: Linearised) -> Bools:
    """Return (S, L) which labels are in the first arc that has any."""
    arcs = np.where(linear.labelled, linear.label_arcs, np.iinfo(np.int64).max)
    first = arcs.min(axis=1, keepdims=True)
    return np.asarray(linear.labelled & (arcs == first))


def _posterior(linear: Linearised, found: ShotFit, prior: float) -> tuple[Floats, Floats]:
    """Return (S, E) steps to the means of the nuisance parameters, and (S, E, E) covariances."""
    count = linear.nuisance_count
    products = gram_matrices(linear, found.noise, found.weights, np.ones(len(found.weights)))
    unlabelled = np.ones(len(found.weights), dtype=bool)
    precision = prior_precision(unlabelled, count, found.noise, prior)
    information = products.positions[:, :count, :count] + precision[..., None] * np.eye(count)
    pull = products.positions[:, :count, -1] - precision * linear.nuisance
    covariance = np.linalg.inv(information)
    step: Floats = np.einsum("sef,sf->se", covariance, pull)
    return step, np.asarray(covariance, dtype=np.float64)
