"""Shot fit: states come out of noisy shots, outliers or not."""

import numpy as np
import pytest

from rallygap.models.gap.fit.noise import Noise
from rallygap.models.gap.fit.shot_fit import fit_shots, refit_shots
from rallygap.models.gap.fit.shots import Shots
from tests.models.gap.hidden import NOMINAL, SETTINGS, launches, measured


def test_states_of_exact_measurements_are_found_exactly():
    shots = measured(count=12, noise=0.0, label=0.0, scatter=(0.0, 0.0, 0.0))
    fit = fit_shots(shots, NOMINAL, SETTINGS.fit)
    true = launches(12, np.random.default_rng(0))
    assert fit.nuisance[:, :3] == pytest.approx(true[:, :3], abs=1e-5)
    assert fit.nuisance[:, 3:6] == pytest.approx(true[:, 3:6], abs=1e-4)
    assert fit.nuisance[:, 6:9] == pytest.approx(true[:, 6:9], abs=0.1)


def test_outliers_are_found_and_change_little():
    shots = measured(count=12)
    random = np.random.default_rng(1)
    outlying = shots.valid & (random.random(shots.valid.shape) < 0.05)
    offsets = np.where(outlying[..., None], random.choice([-0.1, 0.1], shots.positions.shape), 0.0)
    spoiled = Shots(**{**vars(shots), "positions": shots.positions + offsets})
    fit, clean = (
        fit_shots(spoiled, NOMINAL, SETTINGS.fit),
        fit_shots(shots, NOMINAL, SETTINGS.fit),
    )
    assert np.all(fit.weights[outlying] < 0.01)
    assert np.all(fit.weights[shots.valid & ~outlying] > 0.5)
    assert fit.nuisance[:, 3:6] == pytest.approx(clean.nuisance[:, 3:6], abs=0.02)


def test_the_first_guess_of_the_noise():
    fit = fit_shots(measured(count=12, noise=0.006), NOMINAL, SETTINGS.fit)
    assert fit.noise.white == pytest.approx(0.006, rel=0.15)


def test_shots_without_labels_have_the_spin_that_bends_them():
    shots = measured(count=12, labels=None, scatter=(0.0, 0.0, 0.0))
    fit = fit_shots(shots, NOMINAL, SETTINGS.fit)
    true = launches(12, np.random.default_rng(0))
    assert np.median(np.abs(fit.nuisance[:, 6] - true[:, 6])) < 15.0


@pytest.mark.parametrize("times", [1e3, 1e30, 1e160])
def test_implausible_starts_have_a_fit(times):
    shots, late = measured(count=4), NOMINAL.amended("speed_dependent_latency", tau=5e-4)
    start = fit_shots(shots, NOMINAL, SETTINGS.fit).nuisance
    start[:, 3:9] *= times
    fit = refit_shots(shots, late, start, Noise(), SETTINGS.fit)
    assert np.isfinite(fit.cost).all() and np.isfinite(fit.nuisance).all()


def test_starts_at_thousands_of_metres_a_second_along_the_table_have_a_fit():
    shots = measured(count=4)
    start = fit_shots(shots, NOMINAL, SETTINGS.fit).nuisance
    start[:, :6] = -0.003, 0.02, -0.005, 2.8e4, -2.7e4, -4.1e3
    fit = refit_shots(shots, NOMINAL, start, Noise(), SETTINGS.fit)
    assert np.isfinite(fit.cost).all() and np.isfinite(fit.nuisance).all()
