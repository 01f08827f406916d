"""Shares: what each cause has in what all gain, whatever their number."""

import numpy as np
import pytest

from models.gap.inference.set_scores import SetScores
from models.gap.name.gap_share import shares
from tests.models.gap.hidden import SETTINGS


def set_scores(scores, correlation=0.0):
    """Causes of the same information, all equally alike."""
    count = len(scores)
    information = np.full((count, count), correlation) + (1 - correlation) * np.eye(count)
    bounds, refitted = np.tile([-1e3, 1e3], (count, 1)), np.zeros(count, dtype=bool)
    return SetScores(information, np.array(scores), np.zeros(count), bounds, refitted, SETTINGS)


def test_separate_causes_have_what_each_gains_alone():
    found = shares(set_scores([1.0, 2.0, 3.0]), (0, 1, 2))
    assert found == pytest.approx({0: 1.0, 1: 4.0, 2: 9.0})


def test_correlated_causes_share_what_either_explains():
    found = shares(set_scores([3.0, 3.0], correlation=0.5), (0, 1))
    assert found[0] == pytest.approx(found[1])
    assert sum(found.values()) == pytest.approx(2 * 3.0**2 / 1.5)


def test_many_causes_have_all_of_the_gain():
    some = set_scores(np.linspace(1.0, 5.0, 14), correlation=0.3)
    causes = tuple(range(14))
    found = shares(some, causes)
    assert sum(found.values()) == pytest.approx(some.gains(np.array([causes]))[0][0])
    assert found == shares(some, causes)


def test_no_cause_has_no_share():
    assert shares(set_scores([1.0]), ()) == {}
