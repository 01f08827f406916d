"""The transfer table of sim-to-real, by racket_state."""

import pandas as pd

from rallygap.pipeline.report.sim2real import PAPER_ROW, paper_form_table
from rallygap.pipeline.transfer.rates import rates
from tests.pipeline.played_trials import KEYS, everything, trials


def test_the_paper_s_numbers_stand_below_ours():
    table = paper_form_table(rates(everything(), KEYS), ["transformer"])
    ours, theirs = table.to_dict("records")
    assert (ours["learned_predictor"], theirs["learned_predictor"]) == ("transformer", PAPER_ROW)
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
    table = paper_form_table(rates(played, KEYS), ["transformer"])
    assert list(table["set"]) == ["spindoe", "stroke_pro", "stroke_pro"]
    assert table["60-70 ms: physics hits"].notna().tolist() == [False, True, False]
