"""Variance components: noise, label errors and scatter, by restricted likelihood.

A missing effect must not pass for a slow camera error or for scatter. So the values of all
hypotheses are integrated out (labels, scatter), or their significant directions are fitted first
(positions).
"""

from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from scipy.optimize import Bounds, minimize

from rallygap.models.ball.state import SPIN, STATE_SIZE
from rallygap.models.ball.types import Floats
from rallygap.models.gap.fit.linearize import Linearised
from rallygap.models.gap.fit.noise import (
    NORMAL_SPREAD,
    GramMatrices,
    Noise,
    gram_matrices,
    inlier_probability,
    white_gram,
)
from rallygap.models.gap.fit.projection import (
    eliminate_nuisance,
    identifiable_directions,
    nuisance_solution,
)
from rallygap.models.gap.fit.shared_errors import SharedErrors
from rallygap.models.gap.fit.shots import spread_evenly
from rallygap.models.gap.settings import FitSettings
from rallygap.models.gap.types import Bools, Indices


@dataclass(frozen=True)
class NoiseEstimate:
    """Noise of B shots, and their Gram matrices in its metric.

    Attributes:
        noise: its standard deviations.
        weights: (B, N) probabilities that samples are no outliers.
        shot_weights: (B,) 1 for all but shots that fit far worse than most.
        gram_matrices: (B, C, C) Gram matrices of the linearised shots in the metric of the noise.
    """

    noise: Noise
    weights: Floats
    shot_weights: Floats
    gram_matrices: Floats

    def __getitem__(self, rows: Indices) -> "NoiseEstimate":
        """Return the estimate for some of the shots."""
        return NoiseEstimate(
            self.noise, self.weights[rows], self.shot_weights[rows], self.gram_matrices[rows]
        )

    @classmethod
    def known(
        cls, linear: Linearised, noise: Noise, weights: Floats, settings: FitSettings
    ) -> "NoiseEstimate":
        """Return the shots' weights and Gram matrices in a given noise."""
        parts = gram_matrices(linear, noise, weights, np.ones(len(weights)))
        shot_weights = _shot_weights(linear, parts.total(noise), noise, settings)
        return cls(
            noise, weights, shot_weights, replace(parts, shot_weights=shot_weights).total(noise)
        )


def estimate_noise(
    linear: Linearised, noise: Noise, weights: Floats, settings: FitSettings
) -> NoiseEstimate:
    """Estimate the noise of linearised shots, from a first guess of it and of outliers."""
    shot_weights = np.ones(len(weights))
    for _ in range(settings.noise_rounds):
        before = noise.position
        parts = gram_matrices(linear, noise, weights, shot_weights)
        residuals = _residuals(linear, parts.total(noise), noise, settings)
        noise, weights = _inliers(linear, residuals, noise, settings)
        noise = _with_position_noise(linear, parts, noise, weights, settings)
        parts = gram_matrices(linear, noise, weights, np.ones(len(weights)))
        shot_weights = _shot_weights(linear, parts.total(noise), noise, settings)
        some = spread_evenly(len(weights), settings.bounce_shots)
        noise = _with_label_noise_and_scatter(
            _without_shared(linear, replace(parts, shot_weights=shot_weights), noise)[some],
            noise,
            settings,
        )
        if abs(noise.position - before) < settings.noise_converged * before:
            break
    return NoiseEstimate(
        noise, weights, shot_weights, replace(parts, shot_weights=shot_weights).total(noise)
    )


def _residuals(linear: Linearised, total: Floats, noise: Noise, settings: FitSettings) -> Floats:
    """Return (B, N, 3) residuals after nuisance parameters and significant hypotheses."""
    values = _significant_values(linear, total, noise, settings)
    inner = nuisance_solution(total, linear.nuisance_count, values)
    changes = np.concatenate([inner, np.broadcast_to(values, (len(inner), len(values)))], axis=1)
    rest = linear.positions[..., -1] - np.einsum(
        "bnic,bc->bni", linear.positions[..., :-1], changes
    )
    return noise.whiten_timing(rest[..., None], linear.velocities)[..., 0]


def _inliers(
    linear: Linearised, rest: Floats, noise: Noise, settings: FitSettings
) -> tuple[Noise, Floats]:
    """Return (B, N) probabilities that samples are no outliers, and the noise they are judged in.

    It is at least as large as the typical residual: were it not, all samples might be outliers.
    """
    if linear.sampled.any():
        residual_scale = NORMAL_SPREAD * float(np.median(np.abs(rest[linear.sampled])))
        noise = noise.scaled(max(residual_scale / noise.position, 1.0))
    return noise, np.where(linear.sampled, inlier_probability(rest, noise, settings), 0.0)


def shared_errors(linear: Linearised, total: Floats) -> SharedErrors:
    """Return what (B, C, C) Gram matrices say of hypotheses and shared errors."""
    system = eliminate_nuisance(total, linear.nuisance_count)
    return SharedErrors.of(system, len(linear.columns))


def _significant_values(
    linear: Linearised, total: Floats, noise: Noise, settings: FitSettings
) -> Floats:
    """Return (K + F,) values of hypotheses and shared errors along their significant directions."""
    shared = shared_errors(linear, total)
    directions = identifiable_directions(shared.with_prior)
    scores = directions.T @ shared.scores
    significant = np.abs(scores) > settings.significant_direction
    return directions @ np.where(significant, scores, 0.0)


def _with_position_noise(
    linear: Linearised, parts: GramMatrices, noise: Noise, weights: Floats, settings: FitSettings
) -> Noise:
    """Return noise whose position part maximises the restricted likelihood of some shots."""
    some = spread_evenly(len(weights), settings.noise_shots)
    values = _significant_values(linear, parts.total(noise), noise, settings)
    shots = _reduced(linear, some, values)
    shot_weights = parts.shot_weights[some, None, None]
    rest = parts.total(noise)[some] - shot_weights * parts.positions[some]
    nuisance_count = linear.nuisance_count
    beyond = np.concatenate([np.zeros(nuisance_count), -values, [1.0]])
    kept = np.concatenate([np.eye(nuisance_count, len(beyond)), beyond[None]])
    rest = kept @ rest @ kept.T

    def criterion(trial: Noise) -> float:
        products, determinants = white_gram(shots.positions, shots, trial, weights[some])
        left = eliminate_nuisance(shot_weights * products + rest, nuisance_count)
        # Shots without weight must not count in the determinants either.
        weighted = parts.shot_weights[some] * (determinants + left.determinants)
        return float((weighted + left.misfit).sum())

    return _minimised(criterion, noise, ("white", "slow", "slow_time", "timing"), settings)


def _without_shared(linear: Linearised, parts: GramMatrices, noise: Noise) -> GramMatrices:
    """Return Gram matrices of nuisance parameters, hypotheses and residuals less shared errors."""
    if not linear.shots.shared.shape[-1]:
        return parts
    errors = shared_errors(linear, parts.total(noise))
    first, width = linear.of_shared.start, linear.positions.shape[-1]
    kept = np.eye(first + 1, width)
    kept[-1, first:] = [*-errors.coefficients(np.zeros(len(linear.columns))), 1.0]
    return parts.transformed(kept)


def _reduced(linear: Linearised, some: Indices, values: Floats) -> Linearised:
    """Return some shots with nuisance columns and residuals alone, hypotheses subtracted."""
    some_shots, nuisance_count = linear[some], linear.nuisance_count
    residual = some_shots.positions[..., -1] - some_shots.positions[..., nuisance_count:-1] @ values
    columns = np.concatenate(
        [some_shots.positions[..., :nuisance_count], residual[..., None]], axis=-1
    )
    return replace(some_shots, columns=(), positions=columns)


def _with_label_noise_and_scatter(
    parts: GramMatrices, noise: Noise, settings: FitSettings
) -> Noise:
    """Return noise whose label errors and scatter maximise the restricted likelihood."""
    nuisance_count = parts.nuisance.shape[1]
    first = eliminate_nuisance(parts.total(noise), nuisance_count).information.sum(axis=0)
    directions = identifiable_directions(first)

    def criterion(trial: Noise) -> float:
        left = eliminate_nuisance(parts.total(trial), nuisance_count)
        information = directions.T @ left.information.sum(axis=0) @ directions
        score = directions.T @ left.scores.sum(axis=0)
        explained = score @ np.linalg.solve(information, score)
        precision = parts.precision(trial)
        priors = -np.log(np.where(precision > 0.0, precision, 1.0)).sum(axis=1)
        determinants = left.determinants + priors + parts.label_determinants(trial)
        total = parts.shot_weights @ determinants + np.linalg.slogdet(information)[1]
        return float(total + left.misfit.sum() - explained)

    arcs = (parts.counts > 0).sum(axis=1)
    names = ["label"] if arcs.any() else []
    names += ["label_arc"] if (parts.counts > 1).any() else []
    names += ["label_common"] if (arcs > 1).any() else []
    names += ["scatter"] if nuisance_count > STATE_SIZE else []
    return _minimised(criterion, noise, tuple(names), settings) if names else noise


def _minimised(
    criterion: Callable[[Noise], float], noise: Noise, names: tuple[str, ...], settings: FitSettings
) -> Noise:
    """Return noise with the named sizes that minimise ``criterion`` within their bounds."""
    starts = settings.noise_starts
    sizes = [np.atleast_1d(np.maximum(getattr(noise, n), starts.get(n, 0.0))) for n in names]
    ends = np.cumsum([len(size) for size in sizes])
    bounds = [
        settings.noise_bounds[name] for name, size in zip(names, sizes, strict=True) for _ in size
    ]
    limits = np.log(bounds)

    def changed(logarithms: Floats) -> Noise:
        parts = np.split(np.exp(logarithms), ends[:-1])
        values: dict[str, Any] = {
            name: tuple(part.tolist()) if name == "scatter" else float(part[0])
            for name, part in zip(names, parts, strict=True)
        }
        return replace(noise, **values)

    first = np.clip(np.log(np.concatenate(sizes)), limits[:, 0], limits[:, 1])
    result: Any = minimize(  # type: ignore[call-overload]
        lambda logarithms: criterion(changed(logarithms)),
        first.tolist(),
        method="L-BFGS-B",
        bounds=Bounds(*limits.T),
        options={"maxiter": 25.0, "ftol": 1e-7, "eps": 1e-3},
    )
    return changed(result.x)


def _shot_weights(linear: Linearised, total: Floats, noise: Noise, settings: FitSettings) -> Floats:
    """Return (B,) weights of shots: those that fit far worse than most count less.

    First by their fit to the simulator, then by that to the values estimated from all shots.
    """
    left = eliminate_nuisance(total, linear.nuisance_count)
    rows = 3 * (linear.sampled.sum(axis=1) + linear.labelled.sum(axis=1)) - STATE_SIZE
    rows = np.maximum(rows, 1)
    shot_weights = _robust_weights(left.misfit, rows, settings)
    total = total * shot_weights[:, None, None]
    values = _significant_values(linear, total, noise, settings)
    misfit = left.misfit - 2 * left.scores @ values
    misfit += np.einsum("i,bij,j->b", values, left.information, values)
    weights = _robust_weights(misfit, rows, settings)
    return np.where(_plausible(linear, settings), weights, settings.min_shot_weight)


def _plausible(linear: Linearised, settings: FitSettings) -> Bools:
    """Return (B,) which fits are physically plausible; the others ended in a wrong minimum."""
    spin = np.linalg.norm(linear.nuisance[:, SPIN], axis=1)
    kick = np.abs(linear.nuisance[:, STATE_SIZE:]).max(axis=1, initial=0.0)
    plausible: Bools = (spin < settings.max_spin) & (kick < settings.max_plausible_kick)
    return plausible


def _robust_weights(misfit: Floats, rows: Floats, settings: FitSettings) -> Floats:
    """Return weights by how many standard deviations a shot's misfit is beyond the typical one."""
    typical = max(float(np.median(misfit / rows)), settings.min_misfit)
    ratio = misfit / rows / typical
    spread = np.maximum(NORMAL_SPREAD * np.median(np.abs(ratio - 1.0)), np.sqrt(2.0 / rows))
    low, high = settings.misfit_range
    falling = (high - (ratio - 1.0) / spread) / (high - low)
    weights: Floats = np.clip(falling, settings.min_shot_weight, 1.0)
    return weights
