"""Measured effects of deviations from the paper, from small reports."""

import pandas as pd

from rallygap.pipeline.documentation.deviations import BLOCKS
from rallygap.pipeline.io.artifacts import write_csv

OF_RETURNS = {"predictor": "physics", "outcome": "returns", "protocol": "first_window"}
ERRORS = {"set": "arena", "against": "measured", "bounce": "all", "horizon_ms": 300}


def test_a_change_of_returns_has_its_sign_and_says_how_often_it_is_significant(tmp_path):
    rows = [
        {**OF_RETURNS, "difference": -0.2, "p_holm": 0.01},
        {**OF_RETURNS, "difference": 0.03, "p_holm": 0.6},
        {**OF_RETURNS, "predictor": "transformer", "difference": -0.9, "p_holm": 0.01},
        {**OF_RETURNS, "outcome": "hits", "difference": -0.9, "p_holm": 0.01},
    ]
    write_csv(tmp_path / "reports/sim2real/difference.csv", pd.DataFrame(rows))
    found = BLOCKS["deviations.first_window"](tmp_path)
    assert "changes returns by -20 to +3 points (1 of 2 differences significant)" in found


def test_errors_are_those_of_positions_on_the_arena(tmp_path):
    rows = [
        {**ERRORS, "quantity": "position", "predictor": "transformer", "mean": 40.04},
        {**ERRORS, "quantity": "spin", "predictor": "transformer", "mean": 9.0},
        {**ERRORS, "quantity": "position", "predictor": "transformer", "mean": 38.96}
        | {"against": "truth"},
        {**ERRORS, "quantity": "position", "predictor": "oracle", "mean": 28.0},
        {**ERRORS, "quantity": "position", "predictor": "transformer", "mean": 99.0}
        | {"set": "tt3d"},
    ]
    write_csv(tmp_path / "reports/evaluate_predictor/forecast_error.csv", pd.DataFrame(rows))
    found = BLOCKS["deviations.truth"](tmp_path)
    assert "40.0 mm against the measured state, 39.0 mm against the true state" in found


def test_shots_in_reach_are_those_of_the_arena(tmp_path):
    sets = ["receive", "stroke_pro", "stroke_uni", "tt3d"]
    table = pd.DataFrame({"set": sets, "in_reach": [3, 1, 2, 9], "replayed": [30, 10, 20, 90]})
    write_csv(tmp_path / "reports/sim2real/replayed.csv", table)
    assert BLOCKS["deviations.reach"](tmp_path).startswith("1 of 10, 2 of 20, 3 of 30 are in reach")
