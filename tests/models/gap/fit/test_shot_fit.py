"""Shot fit: states come out of noisy shots, outliers or not."""

from dataclasses import replace

import numpy as np
import pytest

from rallygap.models.gap.fit.noise import Noise
from rallygap.models.gap.fit.shot_fit import fit_shots, refit_shots
from tests.models.gap.hidden import NOMINAL, SETTINGS, launches, measured


def test_states_of_exact_measurements_are_found_exactly_and_spins_by_what_bends():
    true = launches(12, np.random.default_rng(0))
    shots = measured(count=12, noise=0.0, label=0.0, scatter=(0.0, 0.0, 0.0))
    fit = fit_shots(shots, NOMINAL, SETTINGS.fit)
    assert fit.nuisance[:, :3] == pytest.approx(true[:, :3], abs=1e-5)
    assert fit.nuisance[:, 3:6] == pytest.approx(true[:, 3:6], abs=1e-4)
    assert fit.nuisance[:, 6:9] == pytest.approx(true[:, 6:9], abs=0.1)
    unlabelled = measured(count=12, labels=None, scatter=(0.0, 0.0, 0.0))
    fit = fit_shots(unlabelled, NOMINAL, SETTINGS.fit)
    assert np.median(np.abs(fit.nuisance[:, 6] - true[:, 6])) < 15.0


def test_outliers_are_found_and_change_little():
    shots = measured(count=12)
    random = np.random.default_rng(1)
    outlying = shots.valid & (random.random(shots.valid.shape) < 0.05)
    offsets = np.where(outlying[..., None], random.choice([-0.1, 0.1], shots.positions.shape), 0.0)
    spoiled = replace(shots, positions=shots.positions + offsets)
    fit, clean = (fit_shots(one, NOMINAL, SETTINGS.fit) for one in (spoiled, shots))
    assert clean.noise.white == pytest.approx(0.003, rel=0.15)
    assert np.all(fit.weights[outlying] < 0.01)
    assert np.all(fit.weights[shots.valid & ~outlying] > 0.5)
    assert fit.nuisance[:, 3:6] == pytest.approx(clean.nuisance[:, 3:6], abs=0.02)


@pytest.mark.parametrize("times", [1e3, 1e160, None])
def test_implausible_starts_have_a_fit(times):
    shots, late = measured(count=4), NOMINAL.amended("speed_dependent_latency", tau=5e-4)
    start = fit_shots(shots, NOMINAL, SETTINGS.fit).nuisance
    if times:
        start[:, 3:9] *= times
    else:  # thousands of metres a second along the table
        start[:, :6] = -0.003, 0.02, -0.005, 2.8e4, -2.7e4, -4.1e3
    fit = refit_shots(shots, late if times else NOMINAL, start, Noise(), SETTINGS.fit)
    assert np.isfinite(fit.cost).all() and np.isfinite(fit.nuisance).all()
