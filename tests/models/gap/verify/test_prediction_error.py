"""Verify: errors before and after, against a floor that perfect simulators reach."""

import numpy as np
import pytest

from models.gap.fit.horizons import first_samples
from models.gap.fit.noise import Noise
from models.gap.fit.refit import fit_nuisance
from models.gap.verify.prediction_error import Errors, errors, gap
from tests.models.gap.hidden import NOMINAL, SETTINGS, measured

NOISE = Noise(white=0.003, slow=1e-5, label=0.05, label_common=1e-3, scatter=(0.01, 0.02, 0.005))
WRONG = NOMINAL.amended("drag", cd=0.2)


def made_up(*sizes):
    """Errors of four shots, the same at both horizons and, in m and in s, at landing."""
    squares = [np.full((4, 2), size**2) for size in sizes]
    landed = np.repeat(np.square([sizes]).T, 4, axis=1)
    return Errors(np.array([0.1, 0.2]), *squares, places=landed, times=landed)


def about(count):
    return fit_nuisance(measured(count=count), NOMINAL, NOISE, settings=SETTINGS.fit)


def test_a_perfect_simulator_reaches_the_floor():
    found = gap(
        errors(about(120), WRONG, NOMINAL, NOISE, (150.0, 150.0), settings=SETTINGS),
        settings=SETTINGS,
    )
    # At the longest horizon some are predicted to miss the edge of the table.
    after, floor = np.array(found.after_mm)[:-1], np.array(found.floor_mm)[:-1]
    assert after == pytest.approx(floor, rel=0.12)
    assert found.removable_closed == pytest.approx(1.0, abs=0.15)
    assert found.before_mm[-1] > 1.5 * found.after_mm[-1]
    landing = found.landing
    assert landing.after_mm == pytest.approx(landing.floor_mm, rel=0.15)
    assert landing.after_ms == pytest.approx(landing.floor_ms, rel=0.15)
    assert landing.reduction_mm[0] > 0.0
    assert landing.reduction_ms[0] > 0.0


def test_the_floor_holds_where_lift_saturates_and_nobody_measured_spins():
    saturated = NOMINAL.amended("magnus", cm=0.4).amended("lift_saturation", kappa=3.0)
    shots = measured(saturated, count=90, labels=None)
    found = gap(
        errors(
            fit_nuisance(shots, saturated, NOISE, settings=SETTINGS.fit),
            NOMINAL,
            saturated,
            NOISE,
            (150.0, 150.0),
            settings=SETTINGS,
        ),
        settings=SETTINGS,
    )
    after, floor = np.array(found.after_mm)[:-1], np.array(found.floor_mm)[:-1]
    assert after == pytest.approx(floor, rel=0.15)


def test_no_change_closes_nothing():
    found = gap(
        errors(about(12), WRONG, WRONG, NOISE, (150.0, 150.0), settings=SETTINGS), settings=SETTINGS
    )
    assert found.before_mm == found.after_mm
    assert found.removable_closed == 0.0
    assert found.landing.reduction_mm == found.landing.reduction_ms == (0.0, 0.0)


def test_twice_the_lift_by_half_the_spin_predicts_as_well_where_nobody_measured_spins():
    twice = NOMINAL.amended("magnus", cm=2 * NOMINAL.effects["magnus"]["cm"])
    shots = measured(count=12, labels=None, seconds=0.25)
    found = errors(
        fit_nuisance(shots, NOMINAL, NOISE, settings=SETTINGS.fit),
        NOMINAL,
        twice,
        NOISE,
        (150.0, 75.0),
        settings=SETTINGS,
    )
    assert np.isfinite(found.before).any()
    assert found.after == pytest.approx(found.before, rel=0.05, nan_ok=True)


def test_the_share_is_a_ratio_of_sums():
    found = gap(made_up(0.005, 0.003, 0.001), settings=SETTINGS)
    assert found.horizons_ms == (100, 200)
    assert found.before_mm == (5.0, 5.0)
    assert found.removable_closed == pytest.approx(0.5)
    assert found.removable_closed_interval == pytest.approx((0.5, 0.5))


def test_landings_are_compared_shot_by_shot():
    landing = gap(made_up(0.005, 0.003, 0.001), settings=SETTINGS).landing
    assert landing.sizes == ((5.0, 5.0), (3.0, 3.0), (1.0, 1.0))
    assert landing.reduction_mm == landing.reduction_ms == pytest.approx((2.0, 2.0))
    assert landing.shots == 4


def test_too_few_landings_are_not_spoken_of():
    found = made_up(0.005, 0.003, 0.001)
    found.places[0, 1:3] = np.nan
    assert gap(found, settings=SETTINGS).landing is None


def test_horizons_that_few_shots_reach_are_left_out():
    found = made_up(0.005, 0.003, 0.001)
    found.before[2:, 1] = np.nan
    assert gap(found, settings=SETTINGS).horizons_ms == (100,)


def test_a_prediction_sees_the_first_samples_alone():
    shots = measured(count=3)
    early = first_samples(shots, SETTINGS.observed_samples)
    assert early.times.shape == (3, SETTINGS.observed_samples)
    last = shots.times[:, SETTINGS.observed_samples - 1 : SETTINGS.observed_samples]
    assert np.all(
        early.label_times[early.labelled]
        <= np.broadcast_to(last, early.labelled.shape)[early.labelled]
    )
    assert early.labelled.sum() == 3 * SETTINGS.observed_samples


def test_intervals_tell_what_shots_drawn_anew_would_err():
    found = made_up(0.005, 0.003, 0.001)
    found.before[:2] *= 1.5
    told = gap(found, settings=SETTINGS)
    for low, high in told.before_interval_mm:
        assert 5.0 <= low < told.before_mm[0] < high <= 5.0 * np.sqrt(1.5)
    assert told.after_interval_mm == ((3.0, 3.0), (3.0, 3.0))
    assert told.reduction_mm[0] >= 2.0


@pytest.mark.parametrize(("after", "worse"), [(0.006, True), (0.00505, False), (0.003, False)])
def test_predictions_that_got_clearly_worse_are_seen(after, worse):
    assert gap(made_up(0.005, after, 0.001), settings=SETTINGS).worse == worse


def test_predictions_that_got_worse_by_chance_are_not_worse():
    found = made_up(0.005, 0.005, 0.001)
    found.after[:] *= np.array([0.8, 1.1, 1.3, 0.9])[:, None]
    assert found.after.mean() > found.before.mean()
    assert not gap(found, settings=SETTINGS).worse
