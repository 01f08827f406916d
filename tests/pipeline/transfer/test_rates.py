"""How often balls are hit and returned, and what a forecaster gains, by racket_state."""

import numpy as np
import pandas as pd
import pytest

from pipeline.transfer.rates import differences, intervals, rates
from tests.pipeline.played_trials import KEYS, everything, trials

SETTING = KEYS[:2]
BASELINE = {"predictor": "physics", "protocol": "every_tick"}


def test_counts_are_means_over_policies_and_rates_over_all_trials():
    table = rates(everything(), KEYS, 200, 0).set_index(KEYS)
    row = table.loc[("stroke_pro", "115-125", "physics", "every_tick")]
    assert (row["balls"], row["hits"], row["returns"]) == (4, 2.5, 1.5)
    assert (row["hit_rate"], row["return_rate"]) == (5 / 8, 3 / 8)
    assert row["return_rate_low"] < 3 / 8 < row["return_rate_high"]
    assert len(table) == 6


def test_differences_are_those_to_the_baseline_on_the_same_balls():
    table = differences(everything(), SETTING, BASELINE, 200, 0)
    found = table.query("horizons_ms == '170-180' and outcome == 'returns'")
    assert list(zip(found["predictor"], found["protocol"], strict=True)) == [
        ("transformer", "every_tick"), ("physics", "first_window")
    ]  # fmt: skip
    gain = found.iloc[0]
    assert gain["difference"] == pytest.approx(2 / 8)
    assert (gain["gained"], gain["lost"]) == (1, 0)  # a ball gained once and lost once is neither
    assert gain["ci_low"] <= gain["difference"] <= gain["ci_high"]


def test_the_baseline_is_who_is_named_whatever_tells_forecasters_apart():
    played = everything().query("protocol == 'every_tick'")
    table = differences(played, SETTING, {"predictor": "transformer"}, 0, 0)
    assert list(table.columns)[:4] == [*SETTING, "predictor", "outcome"]
    assert set(table["predictor"]) == {"physics"}
    returns = table[table["outcome"] == "returns"]
    assert returns["difference"].tolist() == [-2 / 8, -2 / 8]
    assert returns[["gained", "lost"]].to_numpy().tolist() == [[0, 1], [0, 1]]


def test_the_interval_of_a_difference_is_that_of_paired_balls():
    random = np.random.default_rng(0)
    one, other = random.random(900) < 0.8, random.random(900) < 0.7
    other[450:] = one[450:]  # half of the balls end alike
    played = pd.concat([trials(other), trials(one, predictor="transformer")])
    found = differences(played, SETTING, BASELINE, 4000, 0).query("outcome == 'returns'").iloc[0]
    margin = 1.96 * np.std(one.astype(float) - other) / np.sqrt(900)
    assert found["ci_high"] - found["difference"] == pytest.approx(margin, rel=0.1)
    assert found["difference"] - found["ci_low"] == pytest.approx(margin, rel=0.1)


def test_a_second_policy_that_does_the_same_narrows_no_interval():
    single = np.random.default_rng(0).random((1, 400, 1)) < 0.8
    double = np.tile(single, (2, 1, 1))
    assert intervals(double, 1000, 0) == intervals(single, 1000, 0)
