"""Resampled: intervals of root mean squares."""

import numpy as np
import pytest

from rallygap.models.gap.verify.bootstrap import interval, resampled, root_mean_squares
from tests.models.gap.hidden import SETTINGS


def squares(shots=60, seed=0):
    """Errors before, after and at the floor, which shots share but for a millimetre."""
    random = np.random.default_rng(seed)
    common = random.chisquare(2, (1, shots, 2))
    return common * np.array([9.0, 4.0, 1.0])[:, None, None]


def test_draws_scatter_about_the_measured_errors():
    found = squares()
    drawn = resampled(found, SETTINGS.verify.bootstrap_draws)
    assert drawn.mean(axis=0) == pytest.approx(root_mean_squares(found), rel=0.02)
    low, high = interval(drawn[:, 0, 0], 0.95)
    assert low < root_mean_squares(found)[0, 0] < high


def test_draws_are_paired():
    drawn = resampled(squares(), SETTINGS.verify.bootstrap_draws)
    assert drawn[:, 0] / drawn[:, 1] == pytest.approx(np.full((2000, 2), 1.5))


def test_shots_without_an_error_do_not_count():
    found = squares()
    found[:, ::2, 1] = np.nan
    drawn = resampled(found, SETTINGS.verify.bootstrap_draws)
    assert np.isfinite(drawn).all()
    assert drawn[:, :, 1].mean(axis=0) == pytest.approx(root_mean_squares(found)[:, 1], rel=0.05)
