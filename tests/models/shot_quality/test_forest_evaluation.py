"""Judging: matches stay whole, noise is not told, what was planted is, and numbers are right."""

import numpy as np
import pytest

from models.shot_quality.forest_evaluation import (
    base_rate,
    brier,
    calibration,
    folds,
    forest,
    held_out,
    importance,
    logistic,
    roc_auc,
    score,
)
from tests.models.shot_quality.planted import SETTINGS, planted


def told(method, rule, count=900):
    features, wins, matches = planted(count, seed=2, rule=rule)
    parts = folds(features, wins, matches, 5, method)
    return features, wins, matches, parts, held_out(parts, features)


def test_no_match_is_on_both_sides_of_a_fold_and_every_shot_is_left_out_once():
    features, wins, _ = planted(90)
    matches = np.random.default_rng(0).integers(12, size=90)
    learned = []

    def spy(known, _):
        learned.append({float(one) for one in known[:, 0]})
        return lambda shots: np.zeros(len(shots))

    parts = folds(features, wins, matches, 4, spy)
    assert sorted(np.concatenate([part.rows for part in parts])) == list(range(90))
    for part, seen in zip(parts, learned, strict=True):
        own = set(matches[part.rows])
        assert seen == set(features[~np.isin(matches, list(own)), 0])


@pytest.mark.parametrize("method", [forest(SETTINGS, 0), logistic])
def test_noise_is_told_no_better_than_by_chance(method):
    _, wins, _, _, probabilities = told(method, rule=False)
    assert abs(roc_auc(wins, probabilities) - 0.5) < 0.06  # three standard errors


@pytest.mark.parametrize("method", [forest(SETTINGS, 0), logistic])
def test_a_planted_rule_is_told_well_and_better_than_the_base_rate(method):
    _, wins, _, _, probabilities = told(method, rule=True)
    blind = told(base_rate, rule=True)[-1]
    assert roc_auc(wins, probabilities) > 0.85
    assert brier(wins, probabilities) < 0.8 * brier(wins, blind)


def test_the_base_rate_is_that_of_the_other_matches():
    _, wins, _, parts, probabilities = told(base_rate, rule=True)
    for part in parts:
        assert probabilities[part.rows] == pytest.approx(np.delete(wins, part.rows).mean())


def test_too_few_matches_or_outcomes_are_refused():
    features, wins, matches = planted(24)
    with pytest.raises(ValueError, match="4 matches cannot be shared out to 5 parts"):
        folds(features, wins, matches, 5, base_rate)
    with pytest.raises(ValueError, match="all shots end alike"):
        folds(features, np.ones(24, dtype=bool), matches, 2, base_rate)


def test_roc_auc_counts_pairs_and_ties_half():
    wins, probabilities = np.array([True, False, True, False]), np.array([0.9, 0.5, 0.5, 0.1])
    assert roc_auc(wins, probabilities) == pytest.approx((1 + 1 + 0.5 + 1) / 4)
    assert roc_auc(wins, probabilities, np.array([1, 1, 0, 1])) == 1
    assert np.isnan(roc_auc(wins, probabilities, np.array([1, 0, 1, 0])))


def test_intervals_hold_the_score_and_treat_a_match_as_one():
    _, wins, matches, _, probabilities = told(logistic, rule=True, count=300)
    found, low, high = score(brier, wins, probabilities, matches, 400, 0)
    assert low < found == brier(wins, probabilities) < high
    doubled = [np.repeat(one, 2) for one in (wins, probabilities, matches)]
    assert score(brier, *doubled, 400, 0) == pytest.approx((found, low, high))
    assert score(roc_auc, wins, probabilities, matches, 0, 0)[1] == roc_auc(wins, probabilities)


def test_calibration_counts_every_shot_once_in_order_of_probability():
    wins, probabilities = np.arange(40) % 4 == 0, np.linspace(1, 0, 40)
    rows = calibration(wins, probabilities, 4)
    assert rows == [(10, pytest.approx(mean), share) for mean, share in [
        (probabilities[30:].mean(), 0.2), (probabilities[20:30].mean(), 0.3),
        (probabilities[10:20].mean(), 0.2), (probabilities[:10].mean(), 0.3)]]  # fmt: skip


def test_what_was_planted_is_what_matters():
    features, wins, _, parts, _ = told(forest(SETTINGS, 0), rule=True)
    falls = importance(parts, features, wins, np.random.default_rng(0)).mean(axis=0)
    assert falls[3] > 0.25
    assert np.abs(np.delete(falls, 3)).max() < 0.03
