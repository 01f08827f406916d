"""Variance components: the sizes of noise and scatter come out as they went in."""

from dataclasses import replace

import numpy as np
import pytest

from rallygap.models.gap.fit.linearize import linearise
from rallygap.models.gap.fit.noise import Noise
from rallygap.models.gap.fit.shot_fit import fit_shots
from rallygap.models.gap.fit.variance_components import estimate_noise
from rallygap.models.gap.hypotheses import hypotheses
from tests.models.gap.hidden import NOMINAL, SETTINGS, measured


def found(shots, *guess):
    """The noise of shots, from the noise and weights of their fit or from a guess."""
    fit = fit_shots(shots, NOMINAL, SETTINGS.fit)
    linear = linearise(shots, NOMINAL, fit.nuisance, hypotheses(NOMINAL))
    return estimate_noise(linear, *(guess or (fit.noise, fit.weights)), SETTINGS.fit)


def test_noise_and_scatter_are_found():
    noise = found(measured(count=60, scatter=(0.015, 0.03, 0.01), label=0.04)).noise
    assert noise.white == pytest.approx(0.003, rel=0.03)
    assert noise.slow < 0.0006
    assert noise.label == pytest.approx(0.04, rel=0.05)
    assert noise.label_common < 0.01
    assert noise.scatter == pytest.approx((0.015, 0.03, 0.01), rel=0.35)


def test_rounded_time_stamps_are_separated_from_white_noise():
    shots = measured(count=40)
    stamps = np.where(shots.valid, shots.times, np.nan)
    random = np.random.default_rng(1)
    stamps += random.uniform(-5e-4, 5e-4, stamps.shape)
    last = np.nanmax(stamps, axis=1, keepdims=True)
    noise = found(replace(shots, times=np.where(shots.valid, stamps, last))).noise
    assert noise.timing == pytest.approx(1e-3 / np.sqrt(12), rel=0.12)
    assert noise.white == pytest.approx(0.003, rel=0.05)


def test_a_guess_by_which_all_samples_are_outliers_is_corrected():
    shots = measured(count=20)
    known = found(shots, Noise(white=1e-5, slow=1e-5), np.zeros(shots.times.shape))
    assert known.noise.white == pytest.approx(0.003, rel=0.1)
    assert known.weights[shots.valid].mean() > 0.9


def test_a_missing_effect_is_neither_scatter_nor_slow_errors():
    truth = NOMINAL.amended("wind", y=0.3).amended("table_tilt", y=0.01)
    noise = found(measured(truth, count=60)).noise
    assert noise.slow < 0.0006
    assert noise.scatter == pytest.approx((0.01, 0.02, 0.005), rel=0.4)


def test_a_shot_that_fits_far_worse_has_little_weight():
    shots = measured(count=30)
    wobble = 0.007 * np.sin(2 * np.pi * shots.times[4] / 0.2)
    shots.positions[4] += wobble[:, None]
    shot_weights = found(shots).shot_weights
    assert shot_weights[4] < 0.1
    assert np.sum(shot_weights < 1.0) <= 3
