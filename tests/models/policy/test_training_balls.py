"""Practice: playable balls with exact forecasts, by the random numbers alone."""

import numpy as np

from models.policy.forecasts import exact
from models.policy.launches import fair
from models.policy.settings import GoalSettings
from models.policy.training_balls import Practice
from tests.models.policy.incoming_balls import HORIZONS, TRUTH

GOALS = GoalSettings(landing_across=(-0.4, 0.4), landing_along=(0.5, 1.1), speed=None, topspin=None)
PRACTICE = Practice(TRUTH, GOALS, HORIZONS)


def test_practice_gives_playable_balls_with_exact_forecasts_and_a_goal_each():
    incoming, goals = PRACTICE(7, np.random.default_rng(0))
    assert len(incoming) == len(goals) == 7
    assert incoming.start == 0.0 and np.isfinite(incoming.playable).all()
    assert fair(TRUTH, incoming.path[:, 0]).all()
    np.testing.assert_array_equal(incoming.forecasts, exact(incoming.path, HORIZONS))


def test_the_next_balls_are_others_and_the_same_seed_gives_the_same():
    def two_calls():
        random = np.random.default_rng(0)
        return [PRACTICE(5, random) for _ in range(2)]

    (first, first_goals), (second, second_goals) = two_calls()
    assert not np.isclose(first.path[:, 0], second.path[:, 0]).any()
    assert not np.isclose(first_goals.landing, second_goals.landing).any()
    for (incoming, goals), (again, goals_again) in zip(two_calls(), two_calls(), strict=True):
        np.testing.assert_array_equal(incoming.path, again.path)
        np.testing.assert_array_equal(goals.landing, goals_again.landing)
