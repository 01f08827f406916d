"""Metrics are nested by what they belong to and have six digits."""

import pytest

from rallygap.pipeline.io.metrics import place, rounded


@pytest.mark.parametrize(
    ("value", "found"), [(2 / 3, 0.666667), (1234567.0, 1234570.0), (1e-9 / 3, 3.33333e-10), (7, 7)]
)
def test_numbers_have_six_digits_whatever_their_size(value, found):
    assert rounded(value) == found


def test_a_place_is_made_once_and_found_again():
    metrics = {}
    place(metrics, ["set", 100]).update(mean=1.0)
    place(metrics, ["set", 100]).update(std=2.0)
    place(metrics, ["set", 200]).update(mean=3.0)
    assert metrics == {"set": {"100": {"mean": 1.0, "std": 2.0}, "200": {"mean": 3.0}}}
