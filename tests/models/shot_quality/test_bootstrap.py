"""Medians and their bootstrap intervals, compared with numpy's on every resample."""

import numpy as np
import pytest

from rallygap.models.shot_quality.bootstrap import Estimate, resampled_median, weighted_medians


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


def test_without_returns_there_is_no_median_and_without_resamples_no_interval():
    assert np.isnan(resampled_median([], [], 5, 100, 0).interval()).all()
    assert resampled_median([3.0, 1.0], [0, 1], 5, 0, 0).interval() == (2.0, 2.0, 2.0)


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
