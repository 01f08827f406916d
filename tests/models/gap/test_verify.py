"""Verify: errors before and after, against a floor that perfect simulators reach."""

import numpy as np
import pytest

from models.gap.noise import Noise
from models.gap.refit import fitted
from models.gap.verify import SEEN, Errors, errors, first_samples, gap
from tests.models.gap.hidden import NOMINAL, measured

NOISE = Noise(white=0.003, slow=1e-5, label=0.05, label_common=1e-3, scatter=(0.01, 0.02, 0.005))
WRONG = NOMINAL.amended("drag", cd=0.2)


def about(count):
    return fitted(measured(count=count), NOMINAL, NOISE)


def test_a_perfect_simulator_reaches_the_floor():
    found = gap(errors(about(120), WRONG, NOMINAL, NOISE, 150.0))
    # At the longest horizon some are predicted to miss the edge of the table.
    after, floor = np.array(found.after_mm)[:-1], np.array(found.floor_mm)[:-1]
    assert after == pytest.approx(floor, rel=0.12)
    assert found.removable_closed == pytest.approx(1.0, abs=0.15)
    assert found.before_mm[-1] > 1.5 * found.after_mm[-1]


def test_no_change_closes_nothing():
    found = gap(errors(about(12), WRONG, WRONG, NOISE, 150.0))
    assert found.before_mm == found.after_mm
    assert found.removable_closed == 0.0


def test_the_share_is_a_ratio_of_sums():
    squares = [np.full((4, 2), size**2) for size in (0.005, 0.003, 0.001)]
    found = gap(Errors(np.array([0.1, 0.2]), *squares))
    assert found.horizons_ms == (100, 200)
    assert found.before_mm == (5.0, 5.0)
    assert found.removable_closed == pytest.approx(0.5)
    assert found.interval == pytest.approx((0.5, 0.5))


def test_horizons_that_few_shots_reach_are_left_out():
    squares = np.full((4, 2), 1e-6)
    squares[2:, 1] = np.nan
    assert gap(Errors(np.array([0.1, 0.2]), squares, squares, squares)).horizons_ms == (100,)


def test_a_prediction_sees_the_first_samples_alone():
    shots = measured(count=3)
    early = first_samples(shots, SEEN)
    assert early.times.shape == (3, SEEN)
    last = shots.times[:, SEEN - 1 : SEEN]
    assert np.all(
        early.label_times[early.labelled]
        <= np.broadcast_to(last, early.labelled.shape)[early.labelled]
    )
    assert early.labelled.sum() == 3 * SEEN
