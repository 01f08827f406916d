"""Trials of policies: their labels and files, how often balls are returned, what is gained."""

from dataclasses import replace

import numpy as np
import pandas as pd
import pytest

from rallygap.models.ball.simulators import shipped
from rallygap.models.gap.amend.simulator import amended
from rallygap.models.policy.trial import play
from rallygap.pipeline.io.artifacts import write_table
from rallygap.pipeline.runtime.errors import InputError
from rallygap.pipeline.transfer.rates import differences, holm, rates
from rallygap.pipeline.transfer.retraining import retraining_table, share_closed
from rallygap.pipeline.transfer.returns import AFTER, LANDED, read_played
from rallygap.pipeline.transfer.trials import play_policy
from rallygap.pipeline.transfer.truth_comparison import NamedCauses, number_table
from tests.pipeline.amendments import causes
from tests.pipeline.played_trials import KEYS, everything, trials
from tests.pipeline.returned import trials as returned_trials
from tests.pipeline.trained_policies import chaser, description
from tests.pipeline.verdicts import verdict


def test_trials_have_the_policy_s_labels_and_the_forecast_error():
    trained, policy = description(repeat=2, horizons=(170, 175, 180)), chaser()
    task = trained.task
    balls, goals = task.draw(6, np.random.default_rng(0))
    shifted = replace(balls, forecasts=balls.forecasts + 0.02 * np.eye(9)[0])
    table = play_policy(policy, trained, task.simulator, shifted, goals).table
    expected = play(policy, task.simulator, shifted, goals, "intercept").table
    pd.testing.assert_frame_equal(table.iloc[:, :-4], expected)
    assert table["ball"].tolist() == list(range(6))
    assert set(table["horizons_ms"]) == {"170-180"} and set(table["repeat"]) == {2}
    assert table["forecast_error_m"].tolist() == pytest.approx([0.02] * 6)


PLAYED = returned_trials()


def test_returns_and_they_alone_have_states():
    known = PLAYED[[*AFTER, *LANDED]].notna()
    assert PLAYED["returned"].any() and not PLAYED["returned"].all()
    assert (known.all(axis=1) == PLAYED["returned"]).all()
    assert (known.any(axis=1) == PLAYED["returned"]).all()
    back = PLAYED[PLAYED["returned"]]
    speeds = np.linalg.norm(back[AFTER[3:6]], axis=1)
    assert speeds == pytest.approx(back["speed"].to_numpy())


@pytest.mark.parametrize(
    ("change", "message"),
    [
        (lambda table: table.drop(columns="landed_vz"), "landed_vz.*is missing"),
        (lambda table: table.assign(after_wx=np.nan), "a return lacks a value"),
        (lambda table: table.assign(ball=-1), "row 1.*ball"),
    ],
)
def test_a_broken_table_is_one_error(tmp_path, change, message):
    write_table(tmp_path / "played.parquet", change(PLAYED))
    with pytest.raises(InputError, match=message):
        read_played(tmp_path / "played.parquet")


SETTING = KEYS[:2]
BASELINE = {"predictor": "physics", "protocol": "every_tick"}


def test_rates_and_differences_are_those_of_hand_made_trials():
    table = rates(everything(), KEYS).set_index(KEYS)
    row = table.loc[("stroke_pro", "115-125", "physics", "every_tick")]
    assert (row["balls"], row["hits"], row["returns"]) == (4, 2.5, 1.5)
    assert (row["hit_rate"], row["return_rate"]) == (5 / 8, 3 / 8)
    assert row["return_rate_low"] < 3 / 8 < row["return_rate_high"]
    assert len(table) == 6
    table = differences(everything(), SETTING, BASELINE)
    found = table.query("horizons_ms == '170-180' and outcome == 'returns'")
    assert list(zip(found["predictor"], found["protocol"], strict=True)) == [
        ("transformer", "every_tick"), ("physics", "first_window")
    ]  # fmt: skip
    gain = found.iloc[0]
    assert gain["difference"] == pytest.approx(2 / 8)
    assert (gain["gained"], gain["lost"]) == (1, 0)  # a ball gained once and lost once is neither
    assert gain["ci_low"] <= gain["difference"] <= gain["ci_high"]


def test_the_interval_of_a_difference_is_that_of_paired_balls():
    random = np.random.default_rng(0)
    one, other = random.random(900) < 0.8, random.random(900) < 0.7
    other[450:] = one[450:]  # half of the balls end alike
    played = pd.concat([trials(other), trials(one, predictor="transformer")])
    found = differences(played, SETTING, BASELINE).query("outcome == 'returns'").iloc[0]
    margin = 1.96 * np.std(one.astype(float) - other) / np.sqrt(900)
    assert found["ci_high"] - found["difference"] == pytest.approx(margin, rel=0.1)
    assert found["difference"] - found["ci_low"] == pytest.approx(margin, rel=0.1)


def of_trainings(seed):
    """Trials of three trainings that return 60 % of the shots; a recording has three."""
    random = np.random.default_rng(seed)
    table = pd.concat([trials(random.random(150) < 0.6, repeat) for repeat in range(3)])
    return table.assign(recording=table["ball"] // 3)


def test_intervals_cover_a_known_rate():
    found = pd.concat([rates(of_trainings(seed), ["predictor"]) for seed in range(25)])
    covered = (found["return_rate_low"] <= 0.6) & (found["return_rate_high"] >= 0.6)
    assert 0.85 <= covered.mean() <= 1.0


def test_the_correction_is_that_of_holm():
    # Holm 1979: in order, times the number of those left, and never falling.
    p = pd.Series([0.01, 0.04, 0.03, 0.005], index=list("abcd"))
    adjusted = holm(p)
    assert adjusted.index.tolist() == list("abcd")
    np.testing.assert_allclose(adjusted, [0.03, 0.06, 0.06, 0.02])
    assert holm(pd.Series([0.6, 0.9])).tolist() == [1.0, 1.0]


def retrained(oracle=True, own=0.75, times=5):
    """Four balls: physics returns one, the amended simulator two, both changes three; repeated."""
    parts = [
        trials([1, 0, 0, 0] * times, policy="original"),
        trials([1, 0, 0, 0] * times, policy="original", predictor="transformer"),
        trials([0, 1, 1, 0] * times, policy="original", predictor="amended"),
        trials([1, 1, 1, 0] * times, policy="retrained", predictor="amended"),
    ]
    if oracle:
        parts.append(trials([1, 1, 1, 1] * times, policy="original", predictor="oracle"))
    rows = retraining_table(pd.concat(parts, ignore_index=True), {"115-125": own})
    return rows.set_index(["policy", "predictor"])


def test_shares_of_the_gap_are_of_what_the_oracle_gains():
    rows = retrained()
    assert rows["return_rate"].tolist() == [0.25, 0.25, 0.5, 0.75, 1.0]
    closed = rows["gap_closed"]
    assert closed["original", "transformer"] == 0
    assert closed["original", "amended"] == pytest.approx(1 / 3)
    assert closed["retrained", "amended"] == pytest.approx(2 / 3)
    assert closed["original", "oracle"] == 1
    assert np.isnan(closed["original", "physics"])


def test_without_an_oracle_the_gap_is_to_the_rate_in_the_own_simulator():
    closed = retrained(oracle=False)["gap_closed"]
    assert closed["original", "amended"] == pytest.approx(0.25 / 0.5)
    assert closed["retrained", "amended"] == pytest.approx(1)
    assert retrained(oracle=False, own=0.25, times=1)["gap_closed"].isna().all()


def test_there_is_a_share_where_the_gap_is_sure():
    sure, unsure = np.ones((1, 40)), np.resize([1.0, -0.9], (1, 40))
    gain, balls = np.resize([1.0, 0.0], (1, 40)), np.arange(40)
    share, low, high = share_closed(gain, sure, balls)
    assert share == 0.5 and low == pytest.approx(0.35, abs=0.06) and low < 0.5 < high
    assert np.isnan(share_closed(gain, unsure, balls)).all()


ORIGINAL = shipped("imperfect_c")


def numbers(truth):
    found = verdict(causes=causes("imperfect_c", {"drag": {"cd": 0.5}, "wind": {"x": 0.2}}))
    named = NamedCauses.model_validate_json(found.to_json()).causes
    rows = number_table(ORIGINAL, amended(ORIGINAL, found), named, truth)
    return rows.set_index(["effect", "parameter"])


def test_found_and_missed_parameters_are_compared_with_the_truth():
    truth = ORIGINAL.amended("drag", cd=0.55).amended("table_bounce", restitution=0.98)
    rows = numbers(truth.amended("racket_bounce", restitution=0.8))
    assert rows.loc["racket_bounce", "restitution"][["low", "high"]].isna().all()
    drag = rows.loc["drag", "cd"]
    assert drag.tolist() == [0.4, 0.5, 0.49, 0.51, 0.55]
    missed = rows.loc["table_bounce", "restitution"]
    assert missed[["original", "amended", "truth"]].tolist() == [0.9, 0.9, 0.98]
    assert missed[["low", "high"]].isna().all()
    assert ("magnus", "cm") not in rows.index


def test_an_effect_that_a_simulator_lacks_has_no_number_there_and_a_table_of_the_cameras_none():
    rows = numbers(None)
    assert pd.isna(rows.loc["wind", "x"]["original"])
    assert rows.loc["wind", "x"]["amended"] == 0.2
    assert rows["truth"].isna().all()
    nodes = [[0.0, 0.0, 0.2, 1.0, 0.0, 0.0]]
    camera = {"amplitude": 0.002, "length": 0.7, "nodes": nodes}
    rows = number_table(ORIGINAL, ORIGINAL.amended("camera_distortion", **camera), [], None)
    assert rows["parameter"].tolist() == ["amplitude", "length"]
