"""Sets cover what they say, whatever the scale and shape of the covariances."""

import numpy as np
import pytest
from scipy.stats import norm

from rallygap.models.predictors.calibration import LEVELS, NORMAL_MEDIAN, Calibration, Errors, crps

SHAPE = np.array([[4.0, 1.0, 0.0], [1.0, 2.0, 0.5], [0.0, 0.5, 1.0]]) * 1e-4


def errors(count, seed, said=1.0, tail=False):
    """Errors of covariance SHAPE that grows with the horizon, of which ``said`` is said."""
    random = np.random.default_rng(seed)
    growth = np.arange(1.0, 6.0)
    away = random.multivariate_normal(np.zeros(3), SHAPE, (count, 5)) * growth[:, None]
    if tail:
        away *= random.standard_t(3, (count, 5, 1))
    covariances = np.tile(said * SHAPE, (count, 5, 1, 1)) * growth[:, None, None] ** 2
    return Errors(away, covariances)


@pytest.mark.parametrize("said", [0.1, 1.0, 7.0])
@pytest.mark.parametrize("tail", [False, True])
def test_sets_cover_new_errors(said, tail):
    calibration = Calibration.of(errors(4000, 0, said, tail))
    covered = calibration.covered(errors(4000, 1, said, tail)).mean(axis=(1, 2))
    assert covered == pytest.approx(LEVELS, abs=0.015)


def test_sizes_are_radii_of_balls_of_the_same_volume():
    some = errors(50, 0)
    sizes = Calibration(np.ones((2, 5))).sizes(some)
    assert sizes[0, 0] == pytest.approx(np.arange(1, 6) * np.linalg.det(SHAPE) ** (1 / 6))


def test_the_score_is_that_of_the_normal_distribution():
    one = Errors(np.full((1, 1, 3), 0.02), 0.03**2 * np.eye(3)[None, None])
    calibration = Calibration(np.array([[NORMAL_MEDIAN], [2.5]]))
    grid = np.linspace(-0.3, 0.3, 60_001)
    below = (norm(0.0, 0.03).cdf(grid) - (grid >= 0.02)) ** 2
    assert crps(one, calibration) == pytest.approx(np.trapezoid(below, grid), rel=1e-3)


def test_what_was_not_measured_counts_nowhere_and_too_few_errors_give_no_set():
    some = errors(200, 0)
    away = some.away.copy()
    away[:, 4], away[:150, 0] = np.nan, np.nan
    gaps = Errors(away, some.covariances)
    calibration = Calibration.of(gaps)
    assert np.isnan(calibration.radii[:, 4]).all() and np.isfinite(calibration.radii[:, :4]).all()
    assert np.isnan(calibration.covered(gaps)[:, :150, 0]).all()
    assert np.isnan(crps(gaps, calibration)[:150, 0]).all()
    assert np.isnan(Calibration.of(errors(5, 0)).radii[1]).all()
