"""Verdicts follow from the numbers, by rule."""

import numpy as np
import pytest
from scipy.stats import binomtest

from pipeline.paper.judgements import (
    DIFFERS,
    FAILS,
    HIGHER,
    HOLDS,
    LEVEL,
    LOWER,
    NOT_MEASURED,
    OPEN,
    SAME,
    Interval,
    beside,
    claim,
    minus,
    of_all,
    setting,
    share,
    within,
)


@pytest.mark.parametrize(
    ("low", "high", "word"), [(1, 3, HOLDS), (-1, 3, OPEN), (0, 3, OPEN), (-3, -1, FAILS)]
)
def test_a_claim_holds_where_the_whole_interval_is_on_its_side(low, high, word):
    middle = (low + high) / 2
    assert claim(Interval(middle, low, high)) == word
    assert claim(Interval(-middle, -high, -low), grows=False) == word


def test_one_part_that_fails_makes_all_fail_and_one_that_is_missing_leaves_it_open():
    assert of_all([HOLDS, HOLDS]) == HOLDS
    assert of_all([HOLDS, OPEN]) == OPEN
    assert of_all([HOLDS, OPEN, NOT_MEASURED]) == NOT_MEASURED
    assert of_all([HOLDS, NOT_MEASURED, FAILS]) == FAILS
    assert of_all([]) == NOT_MEASURED


@pytest.mark.parametrize(("count", "of"), [(0, 30), (98, 100), (136, 200), (30, 30)])
def test_shares_have_wilson_s_interval(count, of):
    expected = binomtest(count, of).proportion_ci(method="wilson")
    found = share(count, of)
    assert found.value == count / of
    assert found[1:] == pytest.approx((expected.low, expected.high), abs=1e-4)


def test_intervals_of_what_is_measured_apart_cover_as_they_say():
    """Of shares that are a tenth apart, drawn 2,000 times."""
    random = np.random.default_rng(0)
    ones, others = random.binomial(60, 0.8, 2000), random.binomial(200, 0.7, 2000)
    found = [minus(share(a, 60), share(b, 200)) for a, b in zip(ones, others, strict=True)]
    covered = np.mean([one.low <= 0.1 <= one.high for one in found])
    assert 0.93 < covered < 0.97


@pytest.mark.parametrize(
    ("low", "high", "word"),
    [(1.6, 2.4, HOLDS), (1.4, 2.4, OPEN), (1.0, 3.0, OPEN), (0.9, 1.1, FAILS), (2.6, 3.0, FAILS)],
)
def test_what_is_allowed_between_two_ends_holds_as_a_whole(low, high, word):
    assert within(Interval((low + high) / 2, low, high), 1.5, 2.5) == word


def test_numbers_are_level_where_the_difference_may_be_none():
    printed = share(100, 200)
    assert beside(share(30, 60), printed) == LEVEL
    assert beside(share(55, 60), printed) == HIGHER
    assert beside(share(5, 60), printed) == LOWER


def test_settings_are_the_same_to_one_percent():
    assert setting(0.901, 0.9) == SAME and setting(0.92, 0.9) == DIFFERS
    assert setting("Adam", "Adam") == SAME and setting("half a cosine", 0.95) == DIFFERS
    assert setting(None, 3) == NOT_MEASURED
