"""How often balls are hit and returned, and what a forecaster gains, by racket_state."""

import pytest

from pipeline.transfer.rates import differences, rates
from tests.pipeline.played_trials import KEYS, everything

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
