"""Goals: drawn within their limits, of one shape whatever is asked for."""

import numpy as np
import pytest

from rallygap.models.policy.goals import draw_goals
from rallygap.models.policy.settings import GoalSettings

LANDING = {"landing_across": (-0.45, 0.45), "landing_along": (0.5, 1.1)}
STYLED = GoalSettings(**LANDING, speed=(4.0, 7.0), topspin=(-100.0, 100.0))
PLAIN = GoalSettings(**LANDING, speed=None, topspin=None)


def drawn(settings, count=2000):
    return draw_goals(settings, count, np.random.default_rng(0))


def test_goals_fill_their_limits_evenly():
    goals = drawn(STYLED)
    both = [*goals.landing.T, goals.speed, goals.topspin]
    limits = [STYLED.landing_across, STYLED.landing_along, STYLED.speed, STYLED.topspin]
    for values, (low, high) in zip(both, limits, strict=True):
        assert (low <= values).all() and (values <= high).all()
        quarters = np.histogram(values, bins=4, range=(low, high))[0]
        np.testing.assert_allclose(quarters, 500, atol=90)  # 4.6 standard deviations


@pytest.mark.parametrize(("settings", "columns"), [(PLAIN, 2), (STYLED, 4)])
def test_scaled_goals_have_a_column_for_all_that_is_asked(settings, columns):
    largest = np.abs(drawn(settings).scaled()).max(axis=0)
    assert largest.shape == (columns,)
    assert (largest > 0.9).all() and (largest <= 1 + 1e-9).all()
