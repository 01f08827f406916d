"""Checks: noise that is understated is noticed, and few shots are not judged."""

from dataclasses import replace
from functools import cache

import numpy as np
import pytest

from rallygap.models.gap.fit.refit import fit_nuisance
from rallygap.models.gap.verify.checks import checks
from rallygap.models.gap.verify.prediction_error import Errors
from tests.models.gap.hidden import NOISE, NOMINAL, SETTINGS, measured


@cache
def fitted(noise, count):
    return fit_nuisance(measured(count=count), NOMINAL, noise, SETTINGS.fit)


def found(noise=NOISE, count=20, errors=None):
    fit = fitted(noise, count)
    return {check.name: check for check in checks(fit, fit, errors, SETTINGS)}


def errors(after, floor, shots=30):
    """Errors of shots that vary by a few percent, in m, before, after and at the floor."""
    spread = 1 + 0.05 * np.random.default_rng(0).standard_normal((3, shots, 2))
    squares = (np.array([0.02, after, floor])[:, None, None] * spread) ** 2
    return Errors(np.array([0.1, 0.2]), squares, squares.copy())


def test_understated_noise_and_labels_that_err_by_most_of_the_spin_are_noticed():
    fair = found()
    assert fair["residuals"].ratio == pytest.approx(1.0, abs=0.05)
    assert fair["residuals"].passed and fair["labels"].passed
    half = replace(NOISE, white=0.0015, label=0.025, scatter=(0.005, 0.01, 0.0025))
    residuals = found(half)["residuals"]
    assert residuals.ratio == pytest.approx(2.0, rel=0.1)
    assert not residuals.passed
    assert not found(replace(NOISE, label=0.6))["labels"].passed


@pytest.mark.parametrize(("after", "passed"), [(0.010, True), (0.016, False), (0.005, False)])
def test_prediction_errors_must_be_near_the_floor(after, passed):
    of_shots = errors(after, 0.010)
    made = found(errors=of_shots)
    assert made["prediction"].ratio == pytest.approx(after / 0.010, rel=0.05)
    assert (made["prediction"].passed, made["landing"].passed) == (passed, passed)
    if passed:  # one shot that is predicted to miss the table fails no check
        of_shots.squares[1, 3] = of_shots.landings[1, 3] = 0.6**2
        made = found(errors=of_shots)
        assert made["prediction"].passed and made["landing"].passed


def test_few_shots_are_not_judged():
    made = found(count=5, errors=errors(0.03, 0.01, shots=5))
    assert set(made) == {"labels"}


def test_a_restitution_that_differs_more_than_on_any_table_fails():
    assert "bounces" not in found()
    assert found(count=50)["bounces"].passed
    bounces = found(replace(NOISE, scatter=(0.05, 0.02, 0.005)), count=50)["bounces"]
    assert bounces.ratio == 0.05
    assert bounces.interval[0] == pytest.approx(0.05 * (1 - 1.96 / np.sqrt(2 * 50)), rel=0.05)
    assert not bounces.passed
