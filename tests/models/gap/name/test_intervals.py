"""Bounded: intervals hold their estimates, stay within bounds, and have their probability."""

import numpy as np
import pytest
from scipy.stats import truncnorm

from rallygap.models.gap.name.intervals import within
from tests.models.gap.hidden import SETTINGS


@pytest.mark.parametrize("estimate", [-40.0, -3.0, -1.0, 0.0, 0.4, 1.0, 1.9, 2.0, 4.5, 99.0])
@pytest.mark.parametrize("margin", [1e-12, 1e-3, 0.5, 3.0, 1e3])
def test_it_holds_the_estimate_within_the_bounds(estimate, margin):
    value, (low, high) = within(estimate, margin, (0.0, 2.0), SETTINGS)
    assert value == np.clip(estimate, 0.0, 2.0)
    assert 0.0 <= low <= value <= high <= 2.0


@pytest.mark.parametrize("estimate", [-1.0, 0.3, 1.0, 2.5])
def test_it_has_95_percent_of_the_probability_between_the_bounds(estimate):
    error = 0.5
    _, interval = within(estimate, 1.96 * error, (0.0, 2.0), SETTINGS)
    normal = truncnorm(-estimate / error, (2.0 - estimate) / error, estimate, error)
    assert np.ptp(normal.cdf(interval)) == pytest.approx(0.95, abs=1e-4)
    # Far from bounds it is the usual interval.
    assert within(2.0, 0.5, (0.0, 30.0), SETTINGS) == (2.0, pytest.approx((1.5, 2.5), rel=1e-4))
