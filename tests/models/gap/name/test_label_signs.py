"""Label signs: shots whose labels are negated are found, and no others."""

from dataclasses import replace

import numpy as np
import pytest

from models.gap.fit.refit import refit
from models.gap.name.label_signs import LabelSigns, find_flipped_labels
from tests.models.gap.hidden import NOMINAL, SETTINGS, measured

FLIPPED = [2, 5, 11, 17]


def found(shots):
    return find_flipped_labels(shots, refit(shots, NOMINAL, (), SETTINGS.fit), SETTINGS)


@pytest.mark.parametrize("labels", ["rows", "one"])
def test_flipped_labels_are_found_and_corrected(labels):
    shots = measured(count=24, labels=labels)
    sign = np.ones((24, 1, 1))
    sign[FLIPPED] = -1.0
    spoiled = replace(shots, labels=shots.labels * sign)
    signs = found(spoiled)
    assert signs.flipped <= set(FLIPPED)
    assert len(signs.flipped) >= 3
    some = sorted(signs.flipped)
    assert np.array_equal(signs.corrected(spoiled).labels[some], shots.labels[some], equal_nan=True)


def test_correct_labels_are_left_alone():
    assert not found(measured(count=24, seed=4)).flipped


def test_the_interval_of_a_share_is_wilsons():
    signs = LabelSigns(frozenset(range(10)), 100, SETTINGS)
    assert signs.share == 0.1
    assert signs.interval == pytest.approx((0.0552, 0.1744), abs=1e-4)


def test_doubtful_labels_alone_are_left_out():
    shots = measured(count=6)
    left = LabelSigns(frozenset({1, 4}), 6, SETTINGS).left_out(shots)
    assert left.labelled.any(axis=1).tolist() == [True, False, True, True, False, True]
    kept = [0, 2, 3, 5]
    assert np.array_equal(left.labels[kept], shots.labels[kept], equal_nan=True)
    assert shots.labelled.all(axis=1).any()  # the given shots are unchanged
