"""Signs: shots whose labels read backwards are found, and no others."""

from dataclasses import replace

import numpy as np
import pytest

from models.gap.fit.refit import refit
from models.gap.name.label_signs import LabelSigns, find_flipped_labels
from tests.models.gap.hidden import NOMINAL, SETTINGS, measured

BACKWARDS = np.array([2, 5, 11, 17])


@pytest.mark.parametrize("labels", ["rows", "one"])
def test_backward_labels_are_found_and_put_right(labels):
    shots = measured(count=24, labels=labels)
    turn = np.ones((24, 1, 1))
    turn[BACKWARDS] = -1.0
    spoiled = replace(shots, labels=shots.labels * turn)
    found = find_flipped_labels(
        spoiled, refit(spoiled, NOMINAL, (), settings=SETTINGS.fit), settings=SETTINGS
    )
    assert found.flipped <= set(BACKWARDS.tolist())
    assert len(found.flipped) >= 3
    some = sorted(found.flipped)
    assert np.array_equal(found.corrected(spoiled).labels[some], shots.labels[some], equal_nan=True)


def test_right_labels_are_left_alone():
    shots = measured(count=24, seed=4)
    found = find_flipped_labels(
        shots, refit(shots, NOMINAL, (), settings=SETTINGS.fit), settings=SETTINGS
    )
    assert not found.flipped
    assert not found.significant


def test_the_interval_of_a_share_is_wilsons():
    found = LabelSigns(120, frozenset(range(10)), 100, settings=SETTINGS)
    assert found.share == 0.1
    assert found.interval == pytest.approx((0.0552, 0.1744), abs=1e-4)
    assert found.significant


def test_labels_in_doubt_are_left_out_and_no_others():
    shots = measured(count=6)
    left = LabelSigns(6, frozenset({1, 4}), 6, settings=SETTINGS).left_out(shots)
    assert left.labelled.any(axis=1).tolist() == [True, False, True, True, False, True]
    kept = [0, 2, 3, 5]
    assert np.array_equal(left.labels[kept], shots.labels[kept], equal_nan=True)
    assert np.isnan(left.labels[[1, 4]]).all()
    assert shots.labelled.all(axis=1).any()  # which are as they were
