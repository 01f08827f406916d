"""Shared errors: integrated out as by dense matrices; a field of the cameras is found."""

from dataclasses import replace

import numpy as np
import pytest

from models.ball.camera_field import covariance
from models.gap.fit.camera_field import CameraField
from models.gap.fit.projection import ReducedSystem
from models.gap.fit.refit import refit
from models.gap.fit.shared_errors import DistortionLikelihood, SharedErrors
from models.gap.name.distortion import find_distortion
from models.gap.settings import Question
from tests.models.gap.hidden import NOMINAL, SETTINGS, measured

SIZE = 0.3  # standard deviation of the coefficients
RANDOM = np.random.default_rng(0)


def systems(hypotheses, coefficients, shots=6):
    """Rows of shots, and the information and scores that they give in unit noise."""
    rows = RANDOM.standard_normal((shots, 12, hypotheses + coefficients))
    residuals = RANDOM.standard_normal((shots, 12))
    information = np.swapaxes(rows, 1, 2) @ rows
    scores = np.einsum("bik,bi->bk", rows, residuals)
    system = ReducedSystem(information, scores, (residuals**2).sum(axis=1), np.zeros(shots))
    return rows.reshape(-1, rows.shape[-1]), residuals.ravel(), system


def test_hypotheses_have_the_information_of_the_dense_covariance():
    rows, residuals, system = systems(3, 4)
    shared = SharedErrors.of(system, 3, SIZE)
    dense = np.eye(len(rows)) + SIZE**2 * rows[:, 3:] @ rows[:, 3:].T
    information, scores = shared.marginal
    assert information == pytest.approx(rows[:, :3].T @ np.linalg.solve(dense, rows[:, :3]))
    assert scores == pytest.approx(rows[:, :3].T @ np.linalg.solve(dense, residuals))
    before = residuals @ residuals
    assert shared.explained == pytest.approx(before - residuals @ np.linalg.solve(dense, residuals))


def test_parts_of_shots_and_prior_sum_to_the_whole():
    _, _, system = systems(3, 4)
    shared = SharedErrors.of(system, 3, SIZE)
    scores, information = shared.parts(system)
    assert len(scores) == 7
    assert information.sum(axis=0) == pytest.approx(shared.marginal[0])
    assert scores.sum(axis=0) == pytest.approx(shared.marginal[1])


def test_the_restricted_likelihood_is_that_of_dense_matrices():
    rows, residuals, system = systems(2, 5)
    likelihood = DistortionLikelihood.of(SharedErrors.of(system, 2, SIZE), (1e-4, 10.0))

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
    functions = CameraField.over(shots, SETTINGS.fit.camera_field).functions(
        shots.positions[:, ::9]
    )
    places, flat = shots.positions[:, ::9].reshape(-1, 3), functions.reshape(-1, functions.shape[2])
    expected = covariance(places, places, SETTINGS.fit.camera_field.length)
    assert np.quantile(np.abs(flat @ flat.T - expected), 0.99) < 0.03


def test_a_field_of_the_cameras_is_found_and_corrected():
    shots, errors = measured(count=40), field(0.003)
    distorted = replace(shots, positions=shots.positions + errors(shots.positions))
    fit = refit(distorted, NOMINAL, (), SETTINGS.fit)
    found = find_distortion(fit, Question(NOMINAL))
    with_field = refit(found.on(distorted, fit.fitted_places), NOMINAL, (), SETTINGS.fit)
    noise = with_field.noise_estimate.noise
    assert noise.distortion == pytest.approx(0.003, rel=0.4)
    assert noise.white == pytest.approx(0.003, rel=0.03)
    assert noise.slow < 0.0006
    inside = shots.valid & (np.abs(shots.positions[..., 1:2]) < 1.3).all(axis=2)
    left = (with_field.corrected_shots.positions - shots.positions)[inside]
    assert left.std() < 0.6 * errors(shots.positions)[inside].std()


def test_no_field_is_found_where_there_is_none():
    fits = (refit(measured(count=30, seed=seed), NOMINAL, (), SETTINGS.fit) for seed in range(3))
    assert [find_distortion(fit, Question(NOMINAL)) for fit in fits] == [None] * 3
