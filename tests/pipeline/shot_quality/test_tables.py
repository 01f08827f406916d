"""Tables of shot quality, beside sums by hand."""

import numpy as np
import pandas as pd
import pytest

from models.shot_quality.forest import grown
from models.shot_quality.forest_evaluation import forest as forests
from models.shot_quality.shots import FEATURES, Shots
from pipeline.shot_quality.tables import (
    KEYS,
    calibration_table,
    experiments,
    importance_table,
    judged,
    order_kept,
    quality_table,
    return_features,
    returns_table,
    score_rows,
    swap_table,
    unlike_table,
    win_medians,
)
from tests.models.shot_quality.planted import SETTINGS, planted
from tests.pipeline.returned import trials

PLAYED = trials()
BACK = PLAYED[PLAYED["returned"]]


@pytest.fixture(scope="module")
def forest():
    """Grown on the returns themselves, all but the fastest; who lands on the right wins."""
    features = return_features(BACK)
    known = features[:, 3] < np.quantile(features[:, 3], 0.9)
    return grown(features[known], features[known, 0] > 0, SETTINGS, 0)


@pytest.fixture(scope="module")
def returns(forest):
    return returns_table(PLAYED, forest)


def test_every_return_has_its_metrics(returns, forest):
    assert len(returns) == len(BACK)
    spins = np.linalg.norm(BACK[["after_wx", "after_wy", "after_wz"]], axis=1)
    assert returns["spin"].to_numpy() == pytest.approx(spins)
    heights = BACK["net_height"].to_numpy()
    assert returns["clearance"].to_numpy() == pytest.approx(heights - 0.1525 - 0.02)
    told = forest.probabilities(return_features(BACK))
    assert (returns["win_probability"] == told).all()


def test_medians_are_numpy_s_and_lie_in_their_intervals(returns):
    table = quality_table(experiments(PLAYED, returns, 200, 0)).set_index(KEYS)
    assert len(table) == PLAYED.groupby(KEYS).ngroups
    for key, own in returns.groupby(KEYS):
        row = table.loc[key]
        assert row["returns"] == len(own) / 2  # two policies
        for name in ("speed", "spin", "clearance", "win_probability"):
            assert row[name] == pytest.approx(np.median(own[name]))
            assert row[f"{name}_low"] <= row[name] <= row[f"{name}_high"]


def test_what_the_swap_changes_is_of_the_same_balls(returns):
    found = experiments(PLAYED, returns, 200, 0)
    medians, table = quality_table(found).set_index(KEYS), swap_table(found).set_index(KEYS)
    assert len(table) == len(medians) / 2  # all but physics
    for key, row in table.iterrows():
        physics = medians.loc[(*key[:2], "physics", "every_tick")]
        for name in ("speed", "spin", "clearance", "win_probability"):
            assert row[name] == pytest.approx(medians.loc[key, name] / physics[name])
            assert row[f"{name}_low"] <= row[name] <= row[f"{name}_high"]


def test_a_swap_for_the_same_returns_changes_nothing_however_the_balls_fall(returns):
    physics, fell = (table[table["predictor"] == "physics"] for table in (PLAYED, returns))
    found = experiments(
        pd.concat([physics, physics.assign(predictor="same")]),
        pd.concat([fell, fell.assign(predictor="same")]),
        50,
        0,
    )
    assert (swap_table(found).drop(columns=KEYS) == 1).all(axis=None)


def test_an_experiment_without_returns_has_no_medians(returns):
    alone = PLAYED[PLAYED["set"] == "receive"].assign(set="nothing", returned=False)
    table = quality_table(experiments(pd.concat([PLAYED, alone]), returns, 10, 0))
    row = table[table["set"] == "nothing"].iloc[0]
    assert row["returns"] == 0 and np.isnan(row["speed"]) and np.isnan(row["unlike"])


def test_returns_faster_than_all_known_shots_are_unlike_them(returns):
    shares = unlike_table(returns)
    counts = returns.groupby(KEYS, sort=False).size().to_numpy()
    assert (shares["vy"] * counts).sum() == pytest.approx(np.ceil(0.1 * len(BACK)), abs=1.5)
    table = quality_table(experiments(PLAYED, returns, 0, 0))
    assert (table["unlike"].to_numpy() >= shares["vy"].to_numpy()).all()


def test_order_is_kept_where_the_same_predictor_leads():
    index = pd.MultiIndex.from_product([["a"], ["115-125"], ["x", "y", "z"], ["every_tick"]])
    index.names = KEYS
    columns = {"usual": [1.0, 2.0, 3.0], "same": [4.0, 5.0, 9.0], "other": [2.0, 1.0, 3.0]}
    medians = pd.DataFrame(columns, index=index)
    assert order_kept(medians, "same", "usual") == 1
    assert order_kept(medians, "other", "usual") == pytest.approx(2 / 3)
    assert np.isnan(order_kept(medians.iloc[:1], "same", "usual"))


def test_each_forest_tells_its_own_medians(returns, forest):
    features = return_features(BACK)
    table = win_medians(returns, features, {"one": forest, "two": forest})
    own = quality_table(experiments(PLAYED, returns, 0, 0)).set_index(KEYS)["win_probability"]
    assert table["one"].to_numpy() == pytest.approx(own.loc[table.index].to_numpy())
    assert (table["one"] == table["two"]).all()


def test_a_forest_s_scores_calibration_and_importance_are_of_unseen_shots():
    features, wins, matches = planted(400)
    shots = Shots(features, wins, wins, matches)
    found = judged(shots, wins, {"forest": forests(SETTINGS, 0)}, 4)
    (row,) = score_rows(shots, wins, found, 50, 0)
    assert 0.8 < row["roc_auc_low"] < row["roc_auc"] < row["roc_auc_high"] < 1
    curve = calibration_table(shots, found)
    assert curve["shots"].sum() == 400
    assert np.average(curve["share"], weights=curve["shots"]) == pytest.approx(wins.mean())
    table = importance_table(shots, found[0].parts, 0)
    assert table["feature"].iloc[0] == FEATURES[3]
    assert set(table["goes_with"]) <= set(FEATURES)
