"""Label readings: negated labels and outliers are found, and no others."""

from dataclasses import replace

import numpy as np
import pytest

from rallygap.models.gap.fit.refit import refit
from rallygap.models.gap.name.label_readings import LabelReadings, read_labels
from rallygap.models.gap.name.path_spins import PathSpins
from rallygap.models.gap.name.reading_mixture import NEGATED, OUTLIER, ReadingMixture
from tests.models.gap.hidden import NOMINAL, SETTINGS, measured

FLIPPED = [2, 5, 11, 17]


def found(shots):
    return read_labels(shots, refit(shots, NOMINAL, (), SETTINGS.fit), SETTINGS)


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
    assert not found(measured(count=24, seed=4)).doubtful


def test_outliers_are_neither_used_nor_called_flipped():
    shots = measured(count=24, labels="one")
    wrong = [3, 8, 20]
    shots.labels[wrong, 0] = [
        [1400.0, -900.0, 1100.0],
        [-700.0, 800.0, 1500.0],
        [900.0, 900.0, -900.0],
    ]
    readings = found(shots)
    assert readings.outliers == set(wrong)
    assert not readings.flipped
    used = readings.corrected(shots).labelled.any(axis=1)
    assert np.flatnonzero(~used).tolist() == wrong


@pytest.mark.parametrize("gain", [0.5, 1.0, 2.0])
def test_a_wrong_lift_coefficient_does_not_hide_signs(gain):
    """Paths show the product of lift and spin: their spins are too large or too small."""
    random = np.random.default_rng(0)
    spins = random.normal(0.0, 150.0, (30, 3))
    labels = spins * (1 + 0.05 * random.standard_normal((30, 3)))
    labels[FLIPPED] *= -1.0
    paths = PathSpins(np.arange(30), labels, spins / gain, np.tile(400.0 * np.eye(3), (30, 1, 1)))
    readings = ReadingMixture.of(paths).readings(SETTINGS.decisive_gain(30))
    assert np.flatnonzero(readings == NEGATED).tolist() == FLIPPED
    assert not (readings == OUTLIER).any()


def test_doubtful_labels_alone_are_left_out_and_shares_have_wilsons_interval():
    shots, few = measured(count=6), LabelReadings(frozenset({1, 4}), 6, SETTINGS)
    left = few.left_out(shots)
    assert left.labelled.any(axis=1).tolist() == [True, False, True, True, False, True]
    kept = [0, 2, 3, 5]
    assert np.array_equal(left.labels[kept], shots.labels[kept], equal_nan=True)
    assert shots.labelled.all(axis=1).any()  # the given shots are unchanged
    # Too few flipped labels are not used.
    assert few.corrected(shots).labelled.any(axis=1).tolist() == left.labelled.any(axis=1).tolist()
    signs = LabelReadings(frozenset(range(10)), 100, SETTINGS)
    assert signs.share == 0.1
    assert signs.interval == pytest.approx((0.0552, 0.1744), abs=1e-4)
