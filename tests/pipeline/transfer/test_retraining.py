"""Policies retrained in an amended simulator, and this simulator beside the truth."""

import numpy as np
import pandas as pd
import pytest

from rallygap.models.ball.simulators import shipped
from rallygap.models.gap.amend.simulator import amended
from rallygap.pipeline.transfer.retraining import (
    retraining_table,
    share_closed,
)
from rallygap.pipeline.transfer.truth_comparison import NamedCauses, number_table
from tests.pipeline.amendments import causes
from tests.pipeline.played_trials import trials
from tests.pipeline.verdicts import verdict

OWN = {"115-125": 0.75}


def played(oracle=True):
    """Four balls: physics returns one, the amended simulator two, both changes three."""
    parts = [
        trials([1, 0, 0, 0], policy="original"),
        trials([1, 0, 0, 0], policy="original", predictor="transformer"),
        trials([0, 1, 1, 0], policy="original", predictor="amended"),
        trials([1, 1, 1, 0], policy="retrained", predictor="amended"),
    ]
    if oracle:
        parts.append(trials([1, 1, 1, 1], policy="original", predictor="oracle"))
    return pd.concat(parts, ignore_index=True)


def more_balls(few):
    """Five times as many balls that do the same."""
    return pd.concat([few.assign(ball=few["ball"] + 4 * k) for k in range(5)])


def table(of, **changes):
    rows = retraining_table(of, **{"own": OWN, **changes})
    return rows.set_index(["policy", "predictor"])


def test_shares_of_the_gap_are_of_what_the_oracle_gains():
    rows = table(more_balls(played()))
    assert rows["return_rate"].tolist() == [0.25, 0.25, 0.5, 0.75, 1.0]
    closed = rows["gap_closed"]
    assert closed["original", "transformer"] == 0
    assert closed["original", "amended"] == pytest.approx(1 / 3)
    assert closed["retrained", "amended"] == pytest.approx(2 / 3)
    assert closed["original", "oracle"] == 1
    assert np.isnan(closed["original", "physics"])


def test_without_an_oracle_the_gap_is_to_the_rate_in_the_own_simulator():
    closed = table(more_balls(played(oracle=False)))["gap_closed"]
    assert closed["original", "amended"] == pytest.approx(0.25 / 0.5)
    assert closed["retrained", "amended"] == pytest.approx(1)
    rows = table(played(oracle=False), own={"115-125": 0.25})
    assert rows["gap_closed"].isna().all()


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
