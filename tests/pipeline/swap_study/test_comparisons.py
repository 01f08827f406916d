"""Rates and differences of hand-made trials, and Holm's correction."""

import numpy as np
import pandas as pd
import pytest

from pipeline.swap_study.comparisons import differences, holm, rates, two_sided
from tests.pipeline.played_trials import trials

SHOTS, TRAININGS = 60, 3


def played(share, predictor, seed, shots=SHOTS):
    """Trials of three trainings that return a share of the shots; a recording has three."""
    random = np.random.default_rng(seed)
    parts = [trials(random.random(shots) < share, repeat, predictor) for repeat in range(TRAININGS)]
    table = pd.concat(parts, ignore_index=True)
    return table.assign(recording=table["ball"] // 3)


def test_rates_are_means_over_trainings_and_shots():
    table = rates(played(0.5, "physics", 0), ["predictor"], 0)
    (row,) = table.to_dict("records")
    own = played(0.5, "physics", 0)
    assert row["returns"] == pytest.approx(own["returned"].mean())
    assert row["hits"] == pytest.approx(own["hit"].mean())
    assert (row["shots"], row["trainings"]) == (SHOTS, TRAININGS)
    assert row["returns_low"] < row["returns"] < row["returns_high"]


def test_intervals_cover_a_known_rate():
    inside = [
        rates(played(0.6, "physics", seed, shots=150), ["predictor"], seed).iloc[0]
        for seed in range(40)
    ]
    covered = [row["returns_low"] <= 0.6 <= row["returns_high"] for row in inside]
    assert 0.85 <= np.mean(covered) <= 1.0


def test_a_predictor_that_returns_more_is_told_from_one_that_does_not():
    three = [played(0.4, "physics", 0), played(0.9, "oracle", 1), played(0.4, "transformer", 2)]
    gains = differences(pd.concat(three), ["set"], "predictor", "physics", 0)
    returns = gains[gains["outcome"] == "returns"].set_index("predictor")
    assert returns.loc["oracle", "difference"] == pytest.approx(
        three[1]["returned"].mean() - three[0]["returned"].mean()
    )
    assert returns.loc["oracle", "p_holm"] < 0.01
    assert returns.loc["oracle", "ci_low"] > 0
    assert returns.loc["transformer", "p_holm"] > 0.05


def test_equal_trials_have_no_difference():
    one = played(0.5, "physics", 3)
    gains = differences(
        pd.concat([one, one.assign(predictor="oracle")]), ["set"], "predictor", "physics", 0
    )
    assert gains["difference"].abs().max() == 0
    assert (gains["p"] == 1).all()


def test_the_correction_is_that_of_holm():
    # Holm 1979: in order, times the number of those left, and never falling.
    p = pd.Series([0.01, 0.04, 0.03, 0.005], index=list("abcd"))
    adjusted = holm(p)
    assert adjusted.index.tolist() == list("abcd")
    np.testing.assert_allclose(adjusted, [0.03, 0.06, 0.06, 0.02])
    assert holm(pd.Series([0.6, 0.9])).tolist() == [1.0, 1.0]


def test_p_values_of_no_difference_are_uniform():
    random = np.random.default_rng(0)
    values = [
        two_sided(mean + random.standard_normal(2000)) for mean in random.standard_normal(500)
    ]
    assert np.mean(np.array(values) < 0.05) == pytest.approx(0.05, abs=0.025)
    assert np.mean(values) == pytest.approx(0.5, abs=0.05)
