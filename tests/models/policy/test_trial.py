"""Trials: every ball is played once, its row stands where it stood, and nobody's luck matters."""

import numpy as np
import pandas as pd
import pytest

from rallygap.models.policy import trial
from rallygap.models.policy.goals import Goals
from rallygap.models.policy.trial import play
from tests.models.policy.schooling import TASK, drawn_policy, resting_policy
from tests.models.policy.simulations import SIMULATOR, beside_centre, passing

PLACES = [beside_centre(across) for across in (0.3, 0.0, 0.5, 0.02, 0.4, 0.03, 0.0)]
HIT = [False, True, False, True, False, True, True]


def aimed(count, **style):
    """Goals that tell their balls apart."""
    landing = np.column_stack([np.linspace(-0.4, 0.4, count), np.linspace(0.5, 1.1, count)])
    return Goals(landing, **style)


@pytest.mark.parametrize("arms", [3, 32])
def test_rows_stand_in_the_order_of_the_balls_with_their_goals(monkeypatch, arms):
    monkeypatch.setattr(trial, "ENVIRONMENTS", arms)
    goals = aimed(7, speed=np.arange(4.0, 11.0))

    table = play(resting_policy(goals=3), SIMULATOR, passing(*PLACES), goals, "strict").table

    assert table.index.tolist() == list(range(7))
    assert table["hit"].tolist() == HIT
    np.testing.assert_array_equal(table["goal_landing_across"], goals.landing[:, 0])
    np.testing.assert_array_equal(table["goal_landing_along"], goals.landing[:, 1])
    np.testing.assert_array_equal(table["goal_speed"], goals.speed)
    assert "goal_topspin" not in table
    assert table["nearest"][[0, 2, 4]].tolist() == pytest.approx([0.3, 0.5, 0.4], abs=0.003)


def test_it_does_not_matter_how_many_are_played_at_once(monkeypatch):
    balls, goals = TASK.draw(12, np.random.default_rng(5))
    together = play(drawn_policy(), SIMULATOR, balls, goals, "intercept").table
    monkeypatch.setattr(trial, "ENVIRONMENTS", 3)

    in_turn = play(drawn_policy(), SIMULATOR, balls, goals, "intercept").table
    halves = [
        play(drawn_policy(), SIMULATOR, balls[rows], goals[rows], "intercept").table
        for rows in (slice(0, 5), slice(5, 12))
    ]

    pd.testing.assert_frame_equal(in_turn, together, check_exact=True)
    pd.testing.assert_frame_equal(pd.concat(halves, ignore_index=True), together, check_exact=True)
