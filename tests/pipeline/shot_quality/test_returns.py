"""Tables of the returns, compared with direct computations."""

import numpy as np
import pandas as pd
import pytest

from rallygap.models.shot_quality.forest import Forest
from rallygap.models.shot_quality.shots import FEATURES, Shots
from rallygap.pipeline.params import ShotQualitySettings
from rallygap.pipeline.shot_quality.returns import (
    KEYS,
    METRICS,
    experiments,
    order_agreement,
    out_of_range_table,
    quality_table,
    return_features,
    returns_table,
    swap_table,
)
from rallygap.pipeline.shot_quality.validation import (
    calibration_table,
    importance_table,
    score_table,
    validate,
)
from tests.models.shot_quality.planted import SETTINGS, planted
from tests.pipeline.returned import trials

PLAYED = trials()
RETURNED = PLAYED[PLAYED["returned"]]


@pytest.fixture(scope="module")
def forest():
    """Trained on the returns themselves without the fastest; who lands on the right wins."""
    features = return_features(RETURNED)
    known = features[:, 3] < np.quantile(features[:, 3], 0.9)
    return Forest(features[known], features[known, 0] > 0, SETTINGS, 0)


@pytest.fixture(scope="module")
def returns(forest):
    return returns_table(PLAYED, forest)


def test_every_return_has_its_metrics(returns, forest):
    assert len(returns) == len(RETURNED)
    spins = np.linalg.norm(RETURNED[["after_wx", "after_wy", "after_wz"]], axis=1)
    assert returns["spin"].to_numpy() == pytest.approx(spins)
    heights = RETURNED["net_height"].to_numpy()
    assert returns["clearance"].to_numpy() == pytest.approx(heights - 0.1525 - 0.02)
    probabilities = forest.probabilities(return_features(RETURNED))
    assert (returns["win_probability"] == probabilities).all()


def test_medians_are_numpy_s_and_the_swap_divides_them_by_those_of_physics(returns):
    results = experiments(PLAYED, returns, 200, 0)
    medians, ratios = quality_table(results).set_index(KEYS), swap_table(results).set_index(KEYS)
    assert len(medians) == PLAYED.groupby(KEYS).ngroups
    for key, members in returns.groupby(KEYS):
        row = medians.loc[key]
        assert row["returns"] == len(members) / 2  # two policies
        for name in METRICS:
            assert row[name] == pytest.approx(np.median(members[name]))
            assert row[f"{name}_low"] <= row[name] <= row[f"{name}_high"]
    assert len(ratios) == len(medians) / 2  # all but physics
    for key, row in ratios.iterrows():
        physics = medians.loc[(*key[:2], "physics", "every_tick")]
        for name in METRICS:
            assert row[name] == pytest.approx(medians.loc[key, name] / physics[name])
            assert row[f"{name}_low"] <= row[name] <= row[f"{name}_high"]


def test_a_swap_for_the_same_returns_changes_nothing_on_any_resample(returns):
    played, rows = (table[table["predictor"] == "physics"] for table in (PLAYED, returns))
    both = (pd.concat([one, one.assign(predictor="same")]) for one in (played, rows))
    results = experiments(*both, 50, 0)
    assert (swap_table(results).drop(columns=KEYS) == 1).all(axis=None)


def test_returns_faster_than_all_training_shots_are_out_of_range(returns):
    shares = out_of_range_table(returns)
    counts = returns.groupby(KEYS, sort=False).size().to_numpy()
    assert (shares["vy"] * counts).sum() == pytest.approx(np.ceil(0.1 * len(RETURNED)), abs=1.5)
    table = quality_table(experiments(PLAYED, returns, 0, 0))
    assert (table["out_of_range"].to_numpy() >= shares["vy"].to_numpy()).all()


def test_orders_agree_where_the_same_predictor_leads():
    index = pd.MultiIndex.from_product([["a"], ["115-125"], ["x", "y", "z"], ["every_tick"]])
    index.names = KEYS
    columns = {"nominal": [1.0, 2.0, 3.0], "same": [4.0, 5.0, 9.0], "other": [2.0, 1.0, 3.0]}
    medians = pd.DataFrame(columns, index=index)
    assert order_agreement(medians, "same") == 1
    assert order_agreement(medians, "other") == pytest.approx(2 / 3)
    assert np.isnan(order_agreement(medians.iloc[:1], "same"))


def test_scores_calibration_and_importance_are_of_held_out_shots():
    features, wins, matches = planted(400)
    shots = Shots(features, wins, wins, matches)
    settings = ShotQualitySettings(forest=SETTINGS, folds=4, points=10, bootstrap_resamples=50)
    validations = validate(shots, settings, 0)
    scores = score_table(shots, validations, 50, 0).set_index(["outcome", "method"])
    row = scores.loc["wins", "forest"]
    assert 0.8 < row["roc_auc_low"] < row["roc_auc"] < row["roc_auc_high"] < 1
    curve = calibration_table(validations).query("method == 'forest'")
    assert curve["shots"].sum() == 400
    assert np.average(curve["share"], weights=curve["shots"]) == pytest.approx(wins.mean())
    table = importance_table(shots, validations["wins", "forest"], 0)
    assert table["feature"].iloc[0] == FEATURES[3]
    assert table["roc_auc_decrease"].iloc[0] > 0.25
    assert table["roc_auc_decrease"].iloc[1:].abs().max() < 0.03
    assert set(table["most_correlated"]) <= set(FEATURES)
