"""The tables of sim-to-real, by hand."""

import numpy as np
import pandas as pd
import pytest

from pipeline import paper
from pipeline.transfer import THE_PAPER, differences, in_the_form_of_the_paper, rates

KEYS = ["set", "horizons_ms", "predictor", "protocol"]


def trials(returned, repeat=0, predictor="physics", protocol="every_tick", **other):
    """Trials of one policy on as many balls; the returned ones and the last were hit."""
    balls = np.arange(len(returned))
    columns = {
        "set": "stroke_pro", "horizons_ms": "115-125", "repeat": repeat, "predictor": predictor,
        "protocol": protocol, "ball": balls, "returned": np.array(returned, dtype=bool),
    }  # fmt: skip
    hit = columns["returned"] | (balls == balls[-1])
    return pd.DataFrame({**columns, "hit": hit, **other})


def everything():
    """Two policies, three forecasters, two horizons."""
    parts = [
        trials([1, 0, 0, 0], 0), trials([1, 1, 0, 0], 1),
        trials([1, 1, 1, 0], 0, "transformer"), trials([1, 0, 1, 0], 1, "transformer"),
        trials([0, 0, 0, 0], 0, "physics", "first_window"),
        trials([1, 0, 0, 0], 1, "physics", "first_window"),
    ]  # fmt: skip
    near = pd.concat(parts)
    return pd.concat([near, near.assign(horizons_ms="170-180")], ignore_index=True)


def test_counts_are_means_over_policies_and_rates_over_all_trials():
    table = rates(everything(), KEYS, 200, 0).set_index(KEYS)
    row = table.loc[("stroke_pro", "115-125", "physics", "every_tick")]
    assert (row["balls"], row["hits"], row["returns"]) == (4, 2.5, 1.5)
    assert (row["hit_rate"], row["return_rate"]) == (5 / 8, 3 / 8)
    assert row["return_rate_low"] < 3 / 8 < row["return_rate_high"]
    assert len(table) == 6


def test_differences_are_those_to_physics_at_every_tick_on_the_same_balls():
    table = differences(everything(), 200, 0)
    found = table.query("horizons_ms == '170-180' and outcome == 'returns'")
    assert list(zip(found["predictor"], found["protocol"], strict=True)) == [
        ("transformer", "every_tick"), ("physics", "first_window")
    ]  # fmt: skip
    gain = found.iloc[0]
    assert gain["difference"] == pytest.approx(2 / 8)
    assert (gain["gained"], gain["lost"]) == (1, 0)  # a ball gained once and lost once is neither
    assert gain["ci_low"] <= gain["difference"] <= gain["ci_high"]


def test_the_paper_s_numbers_stand_below_ours():
    table = in_the_form_of_the_paper(rates(everything(), KEYS, 0, 0), ["transformer"])
    ours, theirs = table.to_dict("records")
    assert (ours["learned_predictor"], theirs["learned_predictor"]) == ("transformer", THE_PAPER)
    assert (ours["shots"], theirs["shots"]) == (4, 200)
    assert ours["115-125 ms: physics returns"] == 1.5
    assert ours["170-180 ms: learned returns"] == 2.5
    assert theirs["115-125 ms: physics hits"] == 136
    assert theirs["170-180 ms: learned returns"] == 92
    assert len(table.columns) == 3 + 8


def test_sets_and_horizons_that_the_paper_has_not_are_ours_alone():
    own = everything().assign(set="spindoe")
    other = trials([1, 0], horizons_ms="60-70")
    played = pd.concat([own, other, other.assign(predictor="transformer")], ignore_index=True)
    table = in_the_form_of_the_paper(rates(played, KEYS, 0, 0), ["transformer"])
    assert list(table["set"]) == ["spindoe", "stroke_pro", "stroke_pro"]
    assert table["60-70 ms: physics hits"].notna().tolist() == [False, True, False]


def test_no_shot_of_the_paper_is_returned_without_a_hit_and_no_set_has_more_hits_than_shots():
    assert {name for name, _ in paper.TRANSFER} == set(paper.SHOTS)
    for (name, _), found in paper.TRANSFER.items():
        assert found.physics_returns <= found.physics_hits <= paper.SHOTS[name]
        assert found.learned_returns <= found.learned_hits <= paper.SHOTS[name]
