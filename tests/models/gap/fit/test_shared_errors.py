"""Shared errors: integrated out as by dense matrices; a field of the cameras is found."""

from dataclasses import replace

import numpy as np
import pytest

from rallygap.models.ball.camera_field import covariance
from rallygap.models.gap.fit.camera_field import CameraField
from rallygap.models.gap.fit.projection import ReducedSystem
from rallygap.models.gap.fit.refit import refit
from rallygap.models.gap.fit.shared_errors import SharedErrors, VarianceLikelihood
from rallygap.models.gap.name.distortion import find_distortion, with_field
from rallygap.models.gap.name.selection import Explainer, evidence_about
from rallygap.models.gap.settings import Question
from tests.models.gap.hidden import NOMINAL, SETTINGS, measured

FIELD = SETTINGS.fit.camera_field
SIZE = 0.3  # standard deviation of the coefficients


def systems(hypotheses, coefficients, shots=6):
    """Rows of shots, and the information and scores that they give in unit noise."""
    random = np.random.default_rng(0)
    rows = random.standard_normal((shots, 12, hypotheses + coefficients))
    values = SIZE * random.standard_normal(hypotheses + coefficients)
    residuals = rows @ values + random.standard_normal((shots, 12))
    information = np.swapaxes(rows, 1, 2) @ rows
    scores = np.einsum("bik,bi->bk", rows, residuals)
    system = ReducedSystem(information, scores, (residuals**2).sum(axis=1), np.zeros(shots))
    return rows.reshape(-1, rows.shape[-1]), residuals.ravel(), system


def test_hypotheses_have_the_information_of_the_dense_covariance():
    rows, residuals, system = systems(3, 4)
    shared = replace(SharedErrors.of(system, 3), precision=SIZE**-2.0)
    dense = np.eye(len(rows)) + SIZE**2 * rows[:, 3:] @ rows[:, 3:].T
    information, scores = shared.marginal
    assert information == pytest.approx(rows[:, :3].T @ np.linalg.solve(dense, rows[:, :3]))
    assert scores == pytest.approx(rows[:, :3].T @ np.linalg.solve(dense, residuals))
    of_parts = shared.parts(system)
    assert len(of_parts[0]) == 7
    for part, whole in zip(of_parts, (scores, information), strict=True):
        assert part.sum(axis=0) == pytest.approx(whole)
    before = residuals @ residuals
    assert shared.explained == pytest.approx(before - residuals @ np.linalg.solve(dense, residuals))


def test_hypotheses_that_are_left_out_keep_their_values():
    rows, residuals, system = systems(3, 4)
    change, kept = np.array([0.3, -0.2, 0.1]), [0, 2]
    some = SharedErrors.of(system, 3).from_departures(change).about(kept)
    before = residuals + rows[:, :3] @ change
    assert some.scores == pytest.approx(rows[:, [0, 2, 3, 4, 5, 6]].T @ before)
    assert some.alone[0] == pytest.approx(rows[:, kept].T @ rows[:, kept])


def test_the_restricted_likelihood_is_that_of_dense_matrices():
    rows, residuals, system = systems(2, 5)
    likelihood = VarianceLikelihood.of(SharedErrors.of(system, 2), (1e-4, 10.0))

    def dense(size):
        covariances = np.eye(len(rows)) + size**2 * rows[:, 2:] @ rows[:, 2:].T
        white = np.linalg.solve(covariances, np.column_stack([rows[:, :2], residuals]))
        inner = rows[:, :2].T @ white[:, :2]
        score = rows[:, :2].T @ white[:, 2]
        left = residuals @ white[:, 2] - score @ np.linalg.solve(inner, score)
        return left + np.linalg.slogdet(covariances)[1] + np.linalg.slogdet(inner)[1]

    for size in (0.1, 1.0):
        assert likelihood.deviance(size) == pytest.approx(dense(size) - dense(0.0))
    near = (likelihood.deviance(factor * likelihood.estimate) for factor in (0.9, 1.1))
    assert likelihood.deviance(likelihood.estimate) <= min(near)


def field(size, seed=3, length=0.8):
    """A Gaussian field as a sum of random waves."""
    random = np.random.default_rng(seed)
    waves, phases = random.standard_normal((3, 300, 3)) / length, random.uniform(0, 6.3, (3, 300))
    return lambda places: np.stack(
        [
            size * np.sqrt(2 / 300) * np.cos(places @ wave.T + phase).sum(axis=-1)
            for wave, phase in zip(waves, phases, strict=True)
        ],
        axis=-1,
    )


def test_functions_have_the_covariance_of_the_field():
    shots = measured(count=10)
    functions = CameraField.over(shots, FIELD, 0.004).functions(shots.positions[:, ::9])
    places, flat = shots.positions[:, ::9].reshape(-1, 3), functions.reshape(-1, functions.shape[2])
    expected = 0.004**2 * covariance(places, places, FIELD.length)
    assert np.quantile(np.abs(flat @ flat.T - expected), 0.99) < 0.03 * 0.004**2


def distortion(shots, errors=None):
    """The fit of shots, with errors of places, and the position-dependent error that is found."""
    if errors:
        shots = replace(shots, positions=shots.positions + errors(shots.positions))
    fit = refit(shots, NOMINAL, (), SETTINGS.fit)
    return fit, find_distortion(fit, Explainer(evidence_about(fit, Question(NOMINAL)), NOMINAL))


def test_a_field_of_the_cameras_is_found_and_corrected():
    shots, errors = measured(count=50), field(0.003)
    fit, found = distortion(shots, errors)
    assert found.field.size == pytest.approx(0.003, rel=0.4)
    assert found.causes == ()
    with_errors = refit(
        found.field.on(fit.linear.shots, fit.fitted_places), NOMINAL, (), SETTINGS.fit
    )
    noise = with_errors.noise_estimate.noise
    assert noise.white == pytest.approx(0.003, rel=0.03)
    assert noise.slow < 0.0006
    inside = shots.valid & (np.abs(shots.positions[..., 1:2]) < 1.3).all(axis=2)
    left = (with_errors.corrected_shots.positions - shots.positions)[inside]
    assert left.std() < 0.6 * errors(shots.positions)[inside].std()
    low, high = found.size(with_errors).interval(0.95)
    assert found.field.size * low < 0.003 < found.field.size * high


def test_a_field_beside_a_cause_takes_no_place_of_it():
    fit, found = distortion(measured(NOMINAL.amended("drag", cd=0.55), count=40), field(0.003))
    assert [fit.linear.columns[k].identity for k in found.causes] == ["drag.cd"]


def test_a_field_is_implausible_if_its_refit_is_at_the_bound():
    fit, found = distortion(measured(count=30), field(0.003))
    for largest in (0.05, 0.0015):
        bounded = replace(found.field.settings, sizes=(2e-4, largest))
        one = replace(found, field=replace(found.field, settings=bounded))
        plausible = one.is_plausible(with_field(fit, one.field, SETTINGS.fit))
        assert plausible == (largest == 0.05)


def test_no_field_is_found_where_there_is_none_or_a_tilted_frame():
    assert distortion(measured(count=30))[1] is None
    assert distortion(measured(NOMINAL.amended("frame_tilt", y=0.01), count=30))[1] is None
