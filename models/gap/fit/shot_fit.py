"""Fit of each shot's nuisance parameters, given a simulator; B shots at once.

Levenberg-Marquardt on the posterior of state and kicks, with independent noise of one size. The
noise starts large and shrinks (graduated non-convexity, Blake and Zisserman 1987), and the horizon
starts short, so that the predicted ball bounces where the measured one does.
"""

from dataclasses import dataclass, replace

import numpy as np

from rallygap.models.ball.simulator import Simulator
from rallygap.models.ball.types import Floats
from rallygap.models.gap.fit.linearize import ballistic_nuisance, label_counts, label_scales
from rallygap.models.gap.fit.measurement import (
    JUMP,
    Prediction,
    Schedule,
    count_bounces,
    nuisance_derivatives,
    predict_measurements,
)
from rallygap.models.gap.fit.noise import (
    NORMAL_SPREAD,
    Noise,
    deviance,
    inlier_probability,
    prior_precision,
)
from rallygap.models.gap.fit.shots import Shots
from rallygap.models.gap.settings import FitSettings
from rallygap.models.gap.types import Bools, Indices

FALL = np.array([0.0, 0.0, -9.81])
NORMAL_MOST = 1.645  # the size that nine in ten of a standard normal's values are below
# Bounds of nuisance parameters, so that no flight diverges or takes forever, as one along the table
# at many km/s does: m, m/s, rad/s, and kicks.
WORLD, LARGEST_KICK = np.repeat([1e4, 150.0, 5000.0], 3), 3.0


@dataclass(frozen=True)
class ShotFit:
    """Fitted nuisance parameters of B shots.

    Attributes:
        nuisance: (B, 9 + 3 K) states at the first sample, and kicks.
        weights: (B, N) probabilities that samples are no outliers; 0 in padding.
        noise: they were fitted in.
        cost: (B,) twice the negative log posteriors, outliers included in the likelihood.
    """

    nuisance: Floats
    weights: Floats
    noise: Noise
    cost: Floats

    def with_better(self, rows: Indices, other: "ShotFit") -> "ShotFit":
        """Return the shots with those of ``rows`` as another fit has them where that is better."""
        better = other.cost < self.cost[rows]
        taken = rows[better]
        nuisance, weights, cost = self.nuisance.copy(), self.weights.copy(), self.cost.copy()
        nuisance[taken], weights[taken] = other.nuisance[better], other.weights[better]
        cost[taken] = other.cost[better]
        return replace(self, nuisance=nuisance, weights=weights, cost=cost)


def fit_shots(shots: Shots, simulator: Simulator, settings: FitSettings) -> ShotFit:
    """Fit the nuisance parameters of shots from scratch, and guess the noise from the residuals."""
    schedule = Schedule.of(shots)
    nuisance, noise = _within_bounds(_start(shots, settings.first_horizon)), Noise()
    for size, horizon, iterations in settings.stages:
        noise_here = replace(noise, white=size, slow=0.0)
        stage = _Problem.of(shots, simulator, noise_here, settings, horizon)
        nuisance = stage.solved(nuisance, iterations)
    kicks = min(
        int(count_bounces(simulator, schedule, nuisance).max(initial=0)), settings.max_kicks
    )
    large = np.quantile(np.abs(stage.at(nuisance).residual[shots.valid]), settings.noise_quantile)
    white = max(float(large) / NORMAL_MOST, settings.min_noise)
    noise = replace(noise, white=white, slow=white / 3)
    return refit_shots(shots, simulator, ballistic_nuisance(nuisance, kicks), noise, settings)


def refit_shots(
    shots: Shots,
    simulator: Simulator,
    nuisance: Floats,
    noise: Noise,
    settings: FitSettings,
    iterations: int | None = None,
    spin: float | None = None,
) -> ShotFit:
    """Fit the nuisance parameters of shots from given ones.

    Args:
        shots: measured.
        simulator: to fit them with.
        nuisance: (B, 9 + 3 K) where to start.
        noise: by which labels and samples are weighted.
        settings: of the fit.
        iterations: at most, if not those of the settings.
        spin: rad/s, prior of a component of a spin without a label, if not that of the settings.
    """
    problem = _Problem.of(shots, simulator, noise, settings, spin=spin)
    nuisance = _within_bounds(nuisance)
    iterations = settings.max_iterations if iterations is None else iterations
    far = problem.residual_scale(nuisance) / noise.position
    if far > settings.far_residuals:
        wide = replace(problem, noise=noise.scaled(far))
        nuisance = wide.solved(nuisance, iterations)
    return problem.result(problem.solved(nuisance, iterations))


@dataclass(frozen=True)
class _Point:
    """A point of the search: nuisance parameters, their prediction and its residuals.

    ``residual`` is that of positions in m, its timing error whitened; ``errors`` are those of
    labels in units of their noise, which ``scale`` (B, L) converts to, zero without a label.
    """

    nuisance: Floats
    prediction: Prediction
    residual: Floats
    errors: Floats
    scale: Floats
    weights: Floats


@dataclass(frozen=True)
class _Problem:
    shots: Shots
    simulator: Simulator
    noise: Noise
    schedule: Schedule
    used: Bools
    settings: FitSettings
    spin: float

    @classmethod
    def of(
        cls,
        shots: Shots,
        simulator: Simulator,
        noise: Noise,
        settings: FitSettings,
        horizon: float = np.inf,
        spin: float | None = None,
    ) -> "_Problem":
        used = shots.valid & (shots.times - shots.times[:, :1] <= horizon)
        spin = settings.spin_prior if spin is None else spin
        return cls(shots, simulator, noise, Schedule.of(shots), used, settings, spin)

    def __getitem__(self, rows: Indices) -> "_Problem":
        return replace(
            self, shots=self.shots[rows], schedule=self.schedule[rows], used=self.used[rows]
        )

    def solved(self, nuisance: Floats, iterations: int) -> Floats:
        damping = np.full(len(nuisance), self.settings.first_damping)
        left = np.arange(len(nuisance))  # shots that have not converged
        for _ in range(iterations):
            some = self[left]
            point = some.at(nuisance[left])
            step = some._step(point, damping[left])
            trial = some.at(_within_bounds(point.nuisance + step))
            gain = some._cost(point, point.weights) - some._cost(trial, point.weights)
            better = gain >= 0.0
            nuisance[left[better]] = trial.nuisance[better]
            damping[left] *= np.where(better, 0.1, 10.0)
            left = left[np.abs(gain) > self.settings.cost_converged]
            if len(left) == 0:
                break
        return nuisance

    def result(self, nuisance: Floats) -> ShotFit:
        """Return the fit at the last nuisance parameters."""
        point = self.at(nuisance)
        deviances = deviance(point.residual, self.noise, self.settings)
        cost = np.where(self.used, deviances, 0.0).sum(axis=1)
        cost += (point.errors**2).sum(axis=(1, 2))
        cost += (self._precision(nuisance) * nuisance**2).sum(axis=1)
        return ShotFit(nuisance, point.weights, self.noise, cost)

    def residual_scale(self, nuisance: Floats) -> float:
        """Return the standard deviation of a normal with residuals of this median size, m."""
        sizes = np.abs(self.at(nuisance).residual[self.used])
        return NORMAL_SPREAD * float(np.median(sizes))

    def at(self, nuisance: Floats) -> _Point:
        prediction = predict_measurements(self.simulator, self.schedule, nuisance)
        miss = np.where(self.used[..., None], self.shots.positions - prediction.positions, 0.0)
        residual = self.noise.whiten_timing(miss[..., None], prediction.velocities)[..., 0]
        label_times = self.shots.label_times - self.shots.times[:, :1]
        used = self.shots.labelled & prediction.is_smooth(label_times, JUMP)
        variance = self.noise.label_variance(*label_counts(used, prediction.arcs(label_times)))
        scale = used / (label_scales(prediction.labels) * np.sqrt(variance))
        errors = np.nan_to_num(self.shots.labels - prediction.labels) * scale[..., None]
        weights = np.where(self.used, inlier_probability(residual, self.noise, self.settings), 0.0)
        return _Point(nuisance, prediction, residual, errors, scale, weights)

    def _precision(self, nuisance: Floats) -> Floats:
        labelled = np.asarray(self.shots.labelled.any(axis=1))
        return prior_precision(~labelled, nuisance.shape[1], self.noise, self.spin)

    def _cost(self, point: _Point, weights: Floats) -> Floats:
        cost = (weights[..., None] * point.residual**2).sum(axis=(1, 2)) / self.noise.position**2
        cost += (point.errors**2).sum(axis=(1, 2))
        prior = self._precision(point.nuisance)
        total: Floats = cost + (prior * point.nuisance**2).sum(axis=1)
        return total

    def _step(self, point: _Point, damping: Floats) -> Floats:
        count, size = point.nuisance.shape
        slopes = nuisance_derivatives(
            self.simulator, self.schedule, point.nuisance, point.prediction
        )
        scale = np.sqrt(point.weights)[..., None] / self.noise.position
        paths = self.noise.whiten_timing(slopes.positions, point.prediction.velocities)
        rows = np.concatenate(
            [
                (paths * scale[..., None]).reshape(count, -1, size),
                (slopes.labels * point.scale[..., None, None]).reshape(count, -1, size),
            ],
            axis=1,
        )
        misses = (point.residual * scale).reshape(count, -1), point.errors.reshape(count, -1)
        prior = self._precision(point.nuisance)
        normal = np.swapaxes(rows, 1, 2) @ rows + prior[:, :, None] * np.eye(size)
        gradient = np.einsum("bre,br->be", rows, np.concatenate(misses, axis=1))
        diagonal = np.einsum("bii->bi", normal)
        diagonal *= 1 + damping[:, None]
        diagonal += 1e-12 * diagonal.max(axis=1, keepdims=True)
        pull = (gradient - prior * point.nuisance)[..., None]
        return np.linalg.solve(normal, pull)[..., 0]


def _within_bounds(nuisance: Floats) -> Floats:
    most = np.concatenate([WORLD, np.full(nuisance.shape[1] - len(WORLD), LARGEST_KICK)])
    return np.clip(nuisance, -most, most)


def _start(shots: Shots, horizon: float) -> Floats:
    """Return (B, 9) states: a parabola through the first samples, and the first label."""
    t = shots.times - shots.times[:, :1]
    early = shots.valid & (t <= horizon)
    early[:, :4] |= shots.valid[:, :4]
    falling = shots.positions - 0.5 * FALL * t[..., None] ** 2
    weights = early.astype(np.float64)
    for _ in range(8):
        line = _line(t, falling, weights)
        miss = np.linalg.norm(
            falling - line[:, None, :3] - t[..., None] * line[:, None, 3:], axis=2
        )
        residual_scale = np.nanmedian(np.where(early, miss, np.nan), axis=1)[:, None] + 1e-3
        weights = np.where(early, 1 / (1 + (miss / residual_scale) ** 2), 0.0)
    spin = np.nan_to_num(shots.labels[:, 0]) if shots.labels.shape[1] else np.zeros((len(t), 3))
    return np.concatenate([line, spin], axis=1)


def _line(t: Floats, places: Floats, weights: Floats) -> Floats:
    """Return (B, 6) place at time zero and velocity of weighted lines."""
    w = weights[..., None]
    total = w.sum(axis=1)
    mean_t, mean_p = (w * t[..., None]).sum(axis=1) / total, (w * places).sum(axis=1) / total
    since = t[..., None] - mean_t[:, None]
    spread = np.maximum((w * since**2).sum(axis=1), 1e-12)
    velocity = (w * since * places).sum(axis=1) / spread
    return np.concatenate([mean_p - velocity * mean_t, velocity], axis=1)
