"""Balls of a task: playable, with exact forecasts, by the random numbers alone."""

from dataclasses import replace

import numpy as np

from rallygap.models.policy.forecasts import exact
from rallygap.models.policy.incoming_balls import FIRST_WINDOW
from rallygap.models.policy.launches import is_playable
from tests.models.policy.schooling import TASK


def test_a_task_draws_playable_balls_with_exact_forecasts_and_a_goal_each():
    incoming, goals = TASK.draw(7, np.random.default_rng(0))
    assert len(incoming) == len(goals) == 7
    assert incoming.start == 0.0 and np.isfinite(incoming.playable).all()
    assert is_playable(TASK.simulator, incoming.path[:, 0]).all()
    np.testing.assert_array_equal(incoming.forecasts, exact(incoming.path, TASK.horizons))


def test_control_steps_may_begin_with_the_first_window():
    late = replace(TASK, forecasts="exact_after_window")
    incoming, goals = late.draw(7, np.random.default_rng(0))
    early, same_goals = TASK.draw(7, np.random.default_rng(0))
    assert incoming.start == FIRST_WINDOW
    np.testing.assert_array_equal(incoming.path, early.path)
    np.testing.assert_array_equal(goals.landing, same_goals.landing)
    expected = exact(incoming.path, TASK.horizons, FIRST_WINDOW)
    np.testing.assert_array_equal(incoming.forecasts, expected)
