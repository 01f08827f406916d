"""Balls of a task: playable, with exact forecasts, by the random numbers alone."""

import numpy as np

from models.policy.forecasts import exact
from models.policy.launches import is_playable
from tests.models.policy.schooling import TASK


def test_a_task_draws_playable_balls_with_exact_forecasts_and_a_goal_each():
    incoming, goals = TASK.draw(7, np.random.default_rng(0))
    assert len(incoming) == len(goals) == 7
    assert incoming.start == 0.0 and np.isfinite(incoming.playable).all()
    assert is_playable(TASK.simulator, incoming.path[:, 0]).all()
    np.testing.assert_array_equal(incoming.forecasts, exact(incoming.path, TASK.horizons))
