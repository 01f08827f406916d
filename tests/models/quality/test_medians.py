"""Medians and their intervals, beside numpy's own on every resample."""

import numpy as np
import pytest

from models.quality.medians import _medians, median_interval


@pytest.mark.parametrize("size", [1, 2, 9, 10])
def test_medians_of_resamples_are_numpy_s(size):
    random = np.random.default_rng(size)
    values, times = random.normal(size=size).round(1), random.integers(4, size=(200, size))
    expected = [np.median(np.repeat(values, counts)) for counts in times if counts.sum()]
    assert _medians(values, times).tolist() == pytest.approx(expected)


def test_the_interval_is_that_of_balls_drawn_anew():
    random = np.random.default_rng(1)
    balls = np.repeat(np.arange(30), 2)[random.random(60) < 0.7]
    values = random.normal(size=len(balls))
    draws = np.random.default_rng(5).integers(30, size=(1000, 30))
    again = [np.median(np.concatenate([values[balls == one] for one in draw])) for draw in draws]
    median, low, high = median_interval(values, balls, 30, 4000, 7)
    assert median == np.median(values)
    assert [low, high] == pytest.approx(np.quantile(again, [0.025, 0.975]), abs=0.05)


def test_without_returns_there_is_no_median_and_without_resamples_no_interval():
    assert np.isnan(median_interval([], [], 5, 100, 0)).all()
    assert median_interval([3.0, 1.0], [0, 1], 5, 0, 0) == (2.0, 2.0, 2.0)
