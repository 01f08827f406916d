"""Trials: every ball is played once, its row stands where it stood; and scores of made-up ones."""

import numpy as np
import pandas as pd
import pytest

from rallygap.models.policy import trial
from rallygap.models.policy.goals import Goals
from rallygap.models.policy.scores import scores
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


PLAYED = pd.DataFrame(
    {
        "hit": [True, True, True, False, True],
        "returned": [True, True, False, False, True],
        "distance": [0.1, 0.2, 5.0, np.nan, 0.6],
        "speed": [4.0, 4.5, 20.0, np.nan, 5.0],
        "topspin": [-7.0, 3.0, 900.0, np.nan, -7.0],
        "goal_speed": [4.0, 5.0, 9.0, 9.0, 6.0],
    }
)


def test_rates_are_of_all_balls_and_all_else_of_the_returns():
    expected = {"return_rate": 0.6, "hit_rate": 0.8, "landing_error_m": 0.3, "speed_slope": 0.5}
    assert scores(PLAYED) == pytest.approx(expected)  # no slope of what was not asked for
    assert "topspin_slope" in scores(PLAYED.assign(goal_topspin=1.0))


def test_an_undefined_score_is_not_a_number():
    nothing = scores(PLAYED.assign(returned=False))
    assert nothing["return_rate"] == 0
    assert np.isnan([nothing["landing_error_m"], nothing["speed_slope"]]).all()
    assert np.isnan(scores(PLAYED.assign(goal_speed=4.0))["speed_slope"])
