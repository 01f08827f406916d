"""Scores of balls whose ends were made up."""

import numpy as np
import pandas as pd
import pytest

from rallygap.models.policy.scores import scores

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

    assert scores(PLAYED) == pytest.approx(expected)


def test_what_was_not_asked_for_has_no_slope():
    assert "topspin_slope" not in scores(PLAYED)
    assert "topspin_slope" in scores(PLAYED.assign(goal_topspin=1.0))


def test_an_undefined_score_is_not_a_number():
    nothing = scores(PLAYED.assign(returned=False))

    assert nothing["return_rate"] == 0
    assert np.isnan([nothing["landing_error_m"], nothing["speed_slope"]]).all()
    assert np.isnan(scores(PLAYED.assign(goal_speed=4.0))["speed_slope"])
