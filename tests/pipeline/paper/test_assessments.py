"""Assessments follow from the numbers by rule."""

import numpy as np
import pytest

from rallygap.pipeline.paper.assessments import (
    DIFFERS,
    FAILS,
    HOLDS,
    NOT_MEASURED,
    OPEN,
    SAME,
    Interval,
    combined,
    difference,
    rate,
    setting,
    within,
)


@pytest.mark.parametrize(
    ("parts", "word"),
    [
        ([HOLDS, HOLDS], HOLDS),
        ([HOLDS, OPEN], OPEN),
        ([HOLDS, OPEN, NOT_MEASURED], NOT_MEASURED),
        ([HOLDS, NOT_MEASURED, FAILS], FAILS),
        ([], NOT_MEASURED),
    ],
)
def test_a_figure_fails_with_one_claim_and_is_not_measured_without_one(parts, word):
    assert combined(parts) == word


def test_intervals_of_a_difference_of_rates_cover_95_percent():
    random = np.random.default_rng(0)
    counts = random.binomial(60, 0.8, 2000), random.binomial(60, 0.7, 2000)
    rates = {count: rate(count, 60) for count in range(61)}
    found = [difference(rates[a], rates[b]) for a, b in zip(*counts, strict=True)]
    assert 0.93 < np.mean([one.low <= 0.1 <= one.high for one in found]) < 0.97


@pytest.mark.parametrize(
    ("low", "high", "word"),
    [(1.6, 2.4, HOLDS), (1.4, 2.4, OPEN), (1.0, 3.0, OPEN), (0.9, 1.1, FAILS), (2.6, 3.0, FAILS)],
)
def test_a_range_holds_where_the_whole_interval_lies_inside(low, high, word):
    assert within(Interval((low + high) / 2, low, high), 1.5, 2.5) == word


@pytest.mark.parametrize(
    ("ours", "printed", "minimum", "word"),
    [
        (112_975, 100_000, True, SAME),
        (98_000, 100_000, True, DIFFERS),
        (0.901, 0.9, False, SAME),
        (0.92, 0.9, False, DIFFERS),
        ("Adam", "Adam", False, SAME),
        ("half a cosine", 0.95, False, DIFFERS),
    ],
)
def test_settings_are_the_same_to_one_percent_and_a_minimum_may_be_exceeded(
    ours, printed, minimum, word
):
    assert setting(ours, printed, minimum=minimum) == word
