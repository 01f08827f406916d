"""Refit: values of chosen hypotheses that make the shots most likely.

Gauss-Newton on the marginal likelihood. Values stay within their bounds; a weak prior keeps those
of which the shots say nothing where they are.
"""

from dataclasses import dataclass, replace

import numpy as np
from scipy.optimize import lsq_linear

from rallygap.models.ball.simulator import Simulator
from rallygap.models.ball.state import SPIN
from rallygap.models.ball.types import Floats
from rallygap.models.gap.fit.linearize import Linearised, linearise
from rallygap.models.gap.fit.noise import GramMatrices, Noise, gram_matrices
from rallygap.models.gap.fit.projection import ReducedSystem, eliminate_nuisance, nuisance_solution
from rallygap.models.gap.fit.shared_errors import SharedErrors
from rallygap.models.gap.fit.shot_fit import ShotFit, fit_shots, refit_shots
from rallygap.models.gap.fit.shots import Shots
from rallygap.models.gap.fit.variance_components import NoiseEstimate, estimate_noise, shared_errors
from rallygap.models.gap.hypotheses import Hypothesis, hypotheses
from rallygap.models.gap.settings import FitSettings
from rallygap.models.gap.types import Indices


@dataclass(frozen=True)
class RefitResult:
    """Shots fitted about a simulator whose chosen values were refitted.

    Attributes:
        simulator: with the refitted values.
        free: the hypotheses whose values were refitted.
        linear: the shots about it, for all hypotheses.
        noise_estimate: their noise.
    """

    simulator: Simulator
    free: tuple[Hypothesis, ...]
    linear: Linearised
    noise_estimate: NoiseEstimate

    @property
    def shared_errors(self) -> SharedErrors:
        """What the shots say of hypotheses and shared errors."""
        return shared_errors(self.linear, self.noise_estimate.gram_matrices)

    @property
    def camera_errors(self) -> Floats:
        """(F,) maximum-likelihood coefficients of shared errors, with the simulator as it is."""
        return self.shared_errors.coefficients(np.zeros(len(self.linear.columns)))

    @property
    def fitted_places(self) -> Floats:
        """(B, N, 3) m where the fit has the balls at the samples."""
        return self.linear.shots.positions - self.linear.positions[..., -1]

    @property
    def corrected_shots(self) -> Shots:
        """The shots less their shared errors."""
        return self.linear.shots.corrected(self.camera_errors)

    def typical_spin(self, least: float) -> float:
        """Return the size of a component of the shots' spins, rad/s, but no less than ``least``."""
        squares = (self.linear.nuisance[:, SPIN] ** 2).mean(axis=1)
        typical = np.sqrt(np.average(squares, weights=self.noise_estimate.shot_weights))
        return max(float(typical), least)

    def __getitem__(self, rows: Indices) -> "RefitResult":
        """Return some of the shots, about the same simulator in the same noise."""
        return replace(self, linear=self.linear[rows], noise_estimate=self.noise_estimate[rows])


def refit(
    shots: Shots,
    simulator: Simulator,
    free: tuple[Hypothesis, ...],
    settings: FitSettings,
    start: RefitResult | None = None,
) -> RefitResult:
    """Refit the values of ``free``.

    Args:
        shots: of which at least one bounces if a free value is of the table.
        simulator: where the values start; a missing effect is appended.
        free: what is refitted.
        settings: of the fit.
        start: the same shots about a simulator nearby, to start from.
    """
    for hypothesis in free:
        simulator = hypothesis.at(simulator, hypothesis.value(simulator))
    origin = values = _values(simulator, free)
    if start is None:
        fit, steps = fit_shots(shots, simulator, settings), settings.refit_steps
    else:
        fit, steps = _resumed(start, simulator, settings), settings.refit_steps_nearby
    noise_known = start is not None
    shot_weights = np.ones(len(shots)) if start is None else start.noise_estimate.shot_weights
    for _ in range(steps if free else 0):
        linear = linearise(shots, simulator, fit.nuisance, free)
        if not noise_known:
            result = estimate_noise(linear, fit.noise, fit.weights, settings)
            fit = replace(fit, weights=result.weights, noise=result.noise)
            shot_weights = result.shot_weights
        parts = gram_matrices(linear, fit.noise, fit.weights, shot_weights)
        errors = shared_errors(linear, parts.total(fit.noise))
        step, error = _step(errors, free, values, origin, settings)
        stepped = _stepped(linear, parts, fit, step, settings)
        if stepped is None:
            break
        simulator, fit = stepped
        values = _values(simulator, free)
        if (np.abs(step) <= settings.step_converged * error).all():
            break
        noise_known = start is not None or bool((np.abs(step) < settings.step_far * error).all())
    linear = linearise(shots, simulator, fit.nuisance, hypotheses(simulator))
    noise = estimate_noise(linear, fit.noise, fit.weights, settings)
    return RefitResult(simulator, free, linear, noise)


def fit_nuisance(
    shots: Shots, simulator: Simulator, noise: Noise, settings: FitSettings
) -> RefitResult:
    """Fit the nuisance parameters of shots, given a simulator and the noise."""
    start = fit_shots(shots, simulator, settings)
    fit = refit_shots(shots, simulator, start.nuisance, noise, settings)
    linear = linearise(shots, simulator, fit.nuisance, hypotheses(simulator))
    return RefitResult(
        simulator, (), linear, NoiseEstimate.known(linear, noise, fit.weights, settings)
    )


def likelihood_gain(before: RefitResult, after: RefitResult) -> float:
    """Return twice the gain of log likelihood from one fit of the same shots to another.

    It is evaluated in the noise of the later fit, with the samples, labels and shots that both use.
    Errors of labels and time stamps scale with spins and velocities: those of the later fit serve
    for both, or else smaller spins and velocities would pass for a worse fit.
    """
    old, new = _left_by_both(before, after)
    return _misfit(old) - _misfit(new)


def likelihood_gains(before: RefitResult, after: RefitResult) -> Floats:
    """Return the (B,) shots' parts of ``likelihood_gain``; shared errors count as known."""
    old, new = _left_by_both(before, after)
    gains: Floats = old.misfit - new.misfit
    return gains


def _left_by_both(before: RefitResult, after: RefitResult) -> tuple[ReducedSystem, ReducedSystem]:
    """Return shared errors and residuals of both fits, in the noise of the later one."""
    old, new = before.noise_estimate, after.noise_estimate
    about = replace(after.linear, labelled=before.linear.labelled & after.linear.labelled)
    weights = np.minimum(old.weights, new.weights)
    shot_weights = np.minimum(old.shot_weights, new.shot_weights)
    return (
        _left(before.linear, about, new.noise, weights, shot_weights),
        _left(after.linear, about, new.noise, weights, shot_weights),
    )


def _left(
    linear: Linearised, about: Linearised, noise: Noise, weights: Floats, shot_weights: Floats
) -> ReducedSystem:
    units = np.where(about.labelled, linear.label_scales / about.label_scales, 0.0)
    same = replace(
        linear,
        velocities=about.velocities,
        labels=linear.labels * units[..., None, None],
        labelled=about.labelled,
    )
    total = gram_matrices(same, noise, weights, shot_weights).total(noise)
    # Nuisance parameters, shared errors and residuals.
    kept = np.delete(np.arange(total.shape[-1]), linear.of_hypotheses)
    return eliminate_nuisance(total[:, kept[:, None], kept], linear.nuisance_count)


def _misfit(left: ReducedSystem) -> float:
    return float(left.misfit.sum()) - SharedErrors.of(left, 0).explained


def _values(simulator: Simulator, free: tuple[Hypothesis, ...]) -> Floats:
    return np.array([hypothesis.value(simulator) for hypothesis in free])


def _with_values(simulator: Simulator, free: tuple[Hypothesis, ...], values: Floats) -> Simulator:
    for hypothesis, value in zip(free, values, strict=True):
        # A step to a bound may end beyond it by the last digit.
        within = np.clip(value, *hypothesis.declaration.bounds)
        simulator = hypothesis.at(simulator, float(within))
    return simulator


def _resumed(start: RefitResult, simulator: Simulator, settings: FitSettings) -> ShotFit:
    """Return shots fitted about a simulator near that of an earlier refit."""
    linear, known = start.linear, start.noise_estimate
    change = _values(simulator, linear.columns) - _values(start.simulator, linear.columns)
    errors = start.shared_errors.coefficients(change)
    changes = np.concatenate([change, errors])
    nuisance = linear.nuisance + nuisance_solution(
        known.gram_matrices, linear.nuisance_count, changes
    )
    shots = linear.shots.corrected(errors)
    return refit_shots(
        shots, simulator, nuisance, known.noise, settings, settings.nearby_iterations
    )


def _step(
    errors: SharedErrors,
    free: tuple[Hypothesis, ...],
    values: Floats,
    origin: Floats,
    settings: FitSettings,
) -> tuple[Floats, Floats]:
    """Return the best step of the free values within their bounds, and their standard errors."""
    total, scores = errors.marginal
    bounds = np.array([hypothesis.declaration.bounds for hypothesis in free])
    scale = settings.value_prior * np.ptp(bounds, axis=1)
    # In units of the prior's standard deviations, whose precision is one.
    information = total * np.outer(scale, scale) + np.eye(len(free))
    score = scores * scale - (values - origin) / scale
    root = np.linalg.cholesky(information)
    low, high = ((bounds - values[:, None]) / scale[:, None]).T
    result = lsq_linear(root.T, np.linalg.solve(root, score), (low, high))
    return scale * result.x, scale * np.sqrt(np.diag(np.linalg.inv(information)))


def _stepped(
    linear: Linearised, parts: GramMatrices, fit: ShotFit, step: Floats, settings: FitSettings
) -> tuple[Simulator, ShotFit] | None:
    """Return the simulator after as much of a step as fits no worse, and the shots about it."""
    free, noise, values = linear.columns, fit.noise, _values(linear.simulator, linear.columns)
    total = parts.total(noise)
    errors = shared_errors(linear, total)
    shots = linear.shots.corrected(errors.coefficients(0 * step))
    here = refit_shots(shots, linear.simulator, fit.nuisance, noise, settings, 0)
    for part in settings.step_fractions:
        simulator = _with_values(linear.simulator, free, values + part * step)
        shared = errors.coefficients(part * step)
        changes = np.concatenate([part * step, shared])
        nuisance = fit.nuisance + nuisance_solution(total, linear.nuisance_count, changes)
        there = _refitted(linear.shots.corrected(shared), simulator, nuisance, here, settings)
        if parts.shot_weights @ there.cost <= settings.cost_tolerance * (
            parts.shot_weights @ here.cost
        ):
            return simulator, there
    return None


def _refitted(
    shots: Shots, simulator: Simulator, nuisance: Floats, here: ShotFit, settings: FitSettings
) -> ShotFit:
    """Return shots about a simulator nearby; those that fit worse start again where they were.

    One such shot, whose samples pass for outliers, could outweigh what all others gain.
    """
    most = settings.nearby_iterations
    there = refit_shots(shots, simulator, nuisance, here.noise, settings, most)
    lost = np.flatnonzero(there.cost > settings.cost_tolerance * here.cost)
    if not len(lost):
        return there
    again = refit_shots(shots[lost], simulator, here.nuisance[lost], here.noise, settings, most)
    return there.with_better(lost, again)
