"""TrainingBalls: playable balls with exact forecasts, by the random numbers alone."""

import numpy as np

from models.policy.forecasts import exact
from models.policy.launches import is_playable
from models.policy.settings import GoalSettings
from models.policy.training_balls import TrainingBalls
from tests.models.policy.incoming_balls import HORIZONS, TRUTH

GOALS = GoalSettings(landing_across=(-0.4, 0.4), landing_along=(0.5, 1.1), speed=None, topspin=None)
PRACTICE = TrainingBalls(TRUTH, GOALS, HORIZONS)


def test_practice_gives_playable_balls_with_exact_forecasts_and_a_goal_each():
    incoming, goals = PRACTICE(7, np.random.default_rng(0))
    assert len(incoming) == len(goals) == 7
    assert incoming.start == 0.0 and np.isfinite(incoming.playable).all()
    assert is_playable(TRUTH, incoming.path[:, 0]).all()
    np.testing.assert_array_equal(incoming.forecasts, exact(incoming.path, HORIZONS))
