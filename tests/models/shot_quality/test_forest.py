"""The forest, its cross-validation by whole matches, and bootstrap intervals."""

import numpy as np
import pytest
from sklearn.metrics import brier_score_loss, roc_auc_score

from rallygap.models.shot_quality.bootstrap import Estimate, resampled_median, weighted_medians
from rallygap.models.shot_quality.forest import (
    Forest,
    bootstrap_score,
    brier,
    calibration,
    classifiers,
    cross_validate,
    held_out_probabilities,
    roc_auc,
    score,
)
from tests.models.shot_quality.planted import SETTINGS, planted

CLASSIFIERS = classifiers(SETTINGS, 0)


def validated(name, rule, count=900):
    """Outcomes, matches and held-out probabilities of shots."""
    features, wins, matches = planted(count, seed=2, rule=rule)
    folds = cross_validate(CLASSIFIERS[name], features, wins, matches, 5)
    return wins, matches, held_out_probabilities(folds, features)


def test_every_shot_is_held_out_once_with_its_whole_match():
    features, wins, _ = planted(90)
    matches = np.random.default_rng(0).integers(12, size=90)
    folds = cross_validate(CLASSIFIERS["base_rate"], features, wins, matches, 4)
    assert sorted(np.concatenate([rows for rows, _ in folds])) == list(range(90))
    probabilities = held_out_probabilities(folds, features)
    for rows, _ in folds:
        other = ~np.isin(matches, matches[rows])
        assert other.sum() + len(rows) == 90
        assert probabilities[rows] == pytest.approx(wins[other].mean())


@pytest.mark.parametrize("name", ["forest", "logistic"])
def test_a_known_rule_is_learned_and_noise_is_not(name):
    wins, _, probabilities = validated(name, rule=False)
    assert abs(score(roc_auc, wins, probabilities) - 0.5) < 0.06  # three standard errors
    wins, _, probabilities = validated(name, rule=True)
    base_rate = validated("base_rate", rule=True)[-1]
    assert score(roc_auc, wins, probabilities) > 0.85
    assert score(brier, wins, probabilities) < 0.8 * score(brier, wins, base_rate)


def test_a_single_outcome_is_certain_and_refused_in_cross_validation():
    features, wins, matches = planted(24)
    for one in (wins | True, wins & False):
        assert (Forest(features, one, SETTINGS, 0).probabilities(features) == one).all()
        with pytest.raises(ValueError, match="same outcome"):
            cross_validate(CLASSIFIERS["base_rate"], features, one, matches, 2)


def test_scores_are_those_of_scikit_learn():
    random = np.random.default_rng(0)
    wins, probabilities = random.random(60) < 0.4, random.integers(0, 20, 60) / 20
    weights = random.integers(0, 4, (5, 60))
    areas, errors = (one(wins, probabilities, weights) for one in (roc_auc, brier))
    for area, error, weight in zip(areas, errors, weights, strict=True):
        assert area == pytest.approx(roc_auc_score(wins, probabilities, sample_weight=weight))
        loss = brier_score_loss(wins, probabilities, sample_weight=weight)
        assert error == pytest.approx(loss)
    assert np.isnan(roc_auc(wins, probabilities, wins[None].astype(int)))  # without a loss


def test_intervals_contain_the_score_and_resample_whole_matches():
    wins, matches, probabilities = validated("logistic", rule=True, count=300)
    value, low, high = bootstrap_score(brier, wins, probabilities, matches, 400, 0).interval()
    assert low < value == score(brier, wins, probabilities) < high
    doubled = [np.repeat(one, 2) for one in (wins, probabilities, matches)]
    assert bootstrap_score(brier, *doubled, 400, 0).interval() == pytest.approx((value, low, high))
    alone = bootstrap_score(roc_auc, wins, probabilities, matches, 0, 0).interval()
    assert alone == (score(roc_auc, wins, probabilities),) * 3


def test_calibration_bins_hold_equally_many_shots_in_order_of_probability():
    wins, probabilities = np.arange(40) % 4 == 0, np.linspace(1, 0, 40)
    rows = calibration(wins, probabilities, 4)
    assert rows == [(10, pytest.approx(mean), share) for mean, share in [
        (probabilities[30:].mean(), 0.2), (probabilities[20:30].mean(), 0.3),
        (probabilities[10:20].mean(), 0.2), (probabilities[:10].mean(), 0.3)]]  # fmt: skip


def test_out_of_range_is_what_lies_beyond_all_training_shots():
    features, wins, _ = planted()
    forest = Forest(features, wins, SETTINGS, 3)
    assert not forest.out_of_range(features).any()
    beyond = features[:1].copy()
    beyond[0, 2] = features[:, 2].max() + 1e-9
    assert np.flatnonzero(forest.out_of_range(beyond)).tolist() == [2]


@pytest.mark.parametrize("size", [1, 9, 10])
def test_medians_of_resamples_are_numpy_s(size):
    random = np.random.default_rng(size)
    values, counts = random.normal(size=size).round(1), random.integers(4, size=(200, size))
    expected = [np.median(np.repeat(values, row)) if row.any() else np.nan for row in counts]
    assert weighted_medians(values, counts).tolist() == pytest.approx(expected, nan_ok=True)


def test_the_interval_is_that_of_resampled_balls():
    random = np.random.default_rng(1)
    balls = np.repeat(np.arange(30), 2)[random.random(60) < 0.7]
    values = random.normal(size=len(balls))
    draws = np.random.default_rng(5).integers(30, size=(1000, 30))
    medians = [np.median(np.concatenate([values[balls == one] for one in draw])) for draw in draws]
    median, low, high = resampled_median(values, balls, 30, 4000, 7).interval()
    assert median == np.median(values)
    assert [low, high] == pytest.approx(np.quantile(medians, [0.025, 0.975]), abs=0.05)
    assert resampled_median([3.0, 1.0], [0, 1], 5, 0, 0).interval() == (2.0, 2.0, 2.0)
    assert np.isnan(resampled_median([], [], 5, 100, 0).interval()).all()


def test_a_ratio_s_interval_covers_and_is_narrower_for_the_same_balls():
    """Of medians of the same 40 balls, one twice the other, drawn 150 times."""
    random, balls, covered, widths = np.random.default_rng(3), np.arange(40), [], []
    for _ in range(150):
        hard = random.normal(10, 2, 40)
        one, other = 2 * hard * random.normal(1, 0.02, 40), hard * random.normal(1, 0.02, 40)
        below = resampled_median(other, balls, 40, 200, 0)
        _, low, high = resampled_median(one, balls, 40, 200, 0).ratio(below).interval()
        _, wide_low, wide_high = resampled_median(one, balls, 40, 200, 1).ratio(below).interval()
        covered.append(low <= 2 <= high)
        widths.append((high - low) / (wide_high - wide_low))
    assert np.mean(covered) > 0.93
    assert np.mean(widths) < 0.5


def test_a_ratio_needs_a_positive_denominator():
    ratio = Estimate(2.0, np.full(3, 2.0)).ratio(Estimate(-1.0, np.array([0.0, 1.0, np.nan])))
    assert np.isnan(ratio.value)
    assert ratio.resampled.tolist() == pytest.approx([np.nan, 2, np.nan], nan_ok=True)
