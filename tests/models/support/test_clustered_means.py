"""Means over trainings and recordings: against t tests, copies, and simulated truth."""

import numpy as np
import pytest
from scipy.stats import ttest_1samp

from rallygap.models.support.clustered_means import clustered_mean


def drawn(trainings, recordings, shots, of_trainings=0.0, of_recordings=0.0, seed=0):
    """Values with mean zero and unit noise, and the recordings that they are from."""
    random = np.random.default_rng(seed)
    recording = np.repeat(np.arange(recordings), shots)
    values = random.standard_normal((trainings, len(recording)))
    values += of_trainings * random.standard_normal((trainings, 1))
    values += of_recordings * random.standard_normal(recordings)[recording]
    return values[..., None], recording


def assert_same(found, values):
    """Assert that a mean has the interval and the p-value of a t test of independent values."""
    test = ttest_1samp(values, 0.0)
    interval = test.confidence_interval(0.95)
    np.testing.assert_allclose(found.mean, [np.mean(values)])
    np.testing.assert_allclose([found.low[0], found.high[0]], [interval.low, interval.high])
    np.testing.assert_allclose(found.p, [test.pvalue])


@pytest.mark.parametrize("alike", [1, 4])
def test_one_training_is_a_t_test_of_shots_and_those_of_a_recording_that_are_alike_are_one(alike):
    values, recordings = drawn(1, 20, 1)
    found = clustered_mean(np.repeat(values, alike, axis=1) + 0.3, np.repeat(recordings, alike))
    assert_same(found, values[0, :, 0] + 0.3)


def test_trainings_that_do_the_same_narrow_no_interval():
    values, recordings = drawn(1, 20, 2)
    once, twice = (clustered_mean(one, recordings) for one in (values, np.tile(values, (2, 1, 1))))
    np.testing.assert_allclose([twice.low, twice.high], [once.low, once.high])


def test_where_only_trainings_differ_it_is_a_t_test_of_theirs():
    shifts = np.array([0.1, 0.5, 0.9])
    values = np.tile(shifts[:, None, None], (1, 40, 1))
    # Less the variance of the intersection, which is theirs divided by the 40 recordings.
    found = clustered_mean(values, np.arange(40))
    interval = ttest_1samp(shifts, 0.0).confidence_interval(0.95)
    assert found.high[0] - found.mean[0] == pytest.approx(interval.high - 0.5, rel=0.02)


@pytest.mark.parametrize(
    ("of_trainings", "of_recordings"), [(0.0, 0.0), (0.0, 0.5), (0.05, 0.0), (0.15, 0.2), (1.0, 0)]
)
def test_intervals_of_three_trainings_contain_the_truth(of_trainings, of_recordings):
    found = [
        clustered_mean(*drawn(3, 60, 3, of_trainings, of_recordings, seed)) for seed in range(200)
    ]
    covered = np.mean([one.low[0] <= 0 <= one.high[0] for one in found])
    assert 0.86 <= covered <= 0.99
    # An interval contains zero where the p-value does not reject it.
    assert np.mean([one.p[0] >= 0.05 for one in found]) == covered


def test_quantities_are_independent_and_those_without_a_value_are_left_out():
    values, recordings = drawn(2, 15, 2)
    both = np.concatenate([values, 3 * values + 1], axis=2)
    both[0, 4, 0] = np.nan
    found = clustered_mean(both, recordings)
    assert found.mean[0] == pytest.approx(np.nanmean(both[..., 0]))
    alone = clustered_mean(both[..., 1:], recordings)
    np.testing.assert_allclose([found.low[1], found.high[1]], [alone.low[0], alone.high[0]])


def test_a_mean_without_variance_is_certain():
    found = clustered_mean(np.stack([np.zeros((2, 9)), np.ones((2, 9))], axis=2), np.arange(9))
    np.testing.assert_array_equal([found.low, found.high], [[0, 1], [0, 1]])
    np.testing.assert_array_equal(found.p, [1, 0])
