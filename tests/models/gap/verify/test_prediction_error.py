"""Prediction errors before and after, their floor and intervals, and landings."""

import numpy as np
import pytest

from rallygap.models.ball.simulator import Simulator
from rallygap.models.gap.fit.horizons import first_samples
from rallygap.models.gap.fit.refit import fit_nuisance
from rallygap.models.gap.verify.bootstrap import interval, resampled, root_mean_squares
from rallygap.models.gap.verify.landing import landings
from rallygap.models.gap.verify.prediction_error import Errors, HeldOut, gap
from tests.models.gap.hidden import NOISE, NOMINAL, SETTINGS, measured

WRONG = NOMINAL.amended("drag", cd=0.2)
FALLING = Simulator.from_dict(
    {"gravity": {"g": 9.81}, "table_bounce": {"restitution": 0.9, "friction": 0.2}}
)
DROPPED = np.array([[0.1, 0.5, 0.52, 0.2, -1.0, 0.0, 0.0, 0.0, 0.0]])
FALL = np.sqrt(2 * 0.5 / 9.81)  # s


def made_up():
    """Errors of four shots of 5, 3 and 1 mm at two horizons and, in mm and in ms, at landing."""
    squares = np.tile(np.square([0.005, 0.003, 0.001])[:, None, None], (1, 4, 2))
    return Errors(np.array([0.1, 0.2]), squares, squares.copy())


def compared(shots, truth, simulators, spins=(150.0, 150.0)):
    about = fit_nuisance(shots, truth, NOISE, SETTINGS.fit)
    held = HeldOut.of(about, shots, NOISE, SETTINGS)
    return held.errors(simulators, spins, held.shots)


def test_a_correct_simulator_reaches_the_floor():
    found = gap(compared(measured(count=120), NOMINAL, (WRONG, NOMINAL)), SETTINGS)
    # At the longest horizon some are predicted to miss the edge of the table.
    assert found.after_mm[:-1] == pytest.approx(found.floor_mm[:-1], rel=0.12)
    assert found.removable_closed == pytest.approx(1.0, abs=0.15)
    assert found.before_mm[-1] > 1.5 * found.after_mm[-1]
    landing = found.landing
    assert landing.after_mm == pytest.approx(landing.floor_mm, rel=0.15)
    assert landing.after_ms == pytest.approx(landing.floor_ms, rel=0.15)
    assert landing.reduction_mm[0] > 0.0
    assert landing.reduction_ms[0] > 0.0


def test_the_floor_holds_where_lift_saturates_without_spin_labels():
    saturated = NOMINAL.amended("magnus", cm=0.16).amended("lift_saturation", kappa=3.0)
    shots = measured(saturated, count=90, labels=None)
    found = gap(compared(shots, saturated, (NOMINAL, saturated)), SETTINGS)
    assert found.after_mm[:-1] == pytest.approx(found.floor_mm[:-1], rel=0.15)


def test_no_change_closes_nothing():
    found = gap(compared(measured(count=12), NOMINAL, (WRONG, WRONG)), SETTINGS)
    assert found.before_mm == found.after_mm
    assert found.removable_closed == 0.0
    assert found.landing.reduction_mm == found.landing.reduction_ms == (0.0, 0.0)


def test_twice_the_lift_by_half_the_spin_predicts_as_well_without_spin_labels():
    twice = NOMINAL.amended("magnus", cm=2 * NOMINAL.effects["magnus"]["cm"])
    shots = measured(count=12, labels=None, seconds=0.25)
    before, after, _ = compared(shots, NOMINAL, (NOMINAL, twice), (150.0, 75.0)).squares
    assert np.isfinite(before).any()
    assert after == pytest.approx(before, rel=0.05, nan_ok=True)


def test_the_closed_share_is_a_ratio_of_sums():
    found = gap(made_up(), SETTINGS)
    assert found.horizons_ms == (100, 200)
    assert found.before_mm == (5.0, 5.0)
    assert found.removable_closed == pytest.approx(0.5)
    assert found.removable_closed_interval == pytest.approx((0.5, 0.5))
    assert found.landing.sizes == ((5.0, 5.0), (3.0, 3.0), (1.0, 1.0))
    assert found.landing.reduction_mm == found.landing.reduction_ms == pytest.approx((2.0, 2.0))


def test_too_few_landings_and_horizons_that_few_shots_reach_are_left_out():
    found = made_up()
    found.landings[0, 1:3, 0] = np.nan
    found.squares[0, 2:, 1] = np.nan
    assert gap(found, SETTINGS).landing is None
    assert gap(found, SETTINGS).horizons_ms == (100,)


def test_a_prediction_uses_the_first_samples_alone():
    shots, count = measured(count=3), SETTINGS.observed_samples
    early = first_samples(shots, count)
    assert early.times.shape == (3, count)
    assert np.nanmax(early.label_times - shots.times[:, count - 1 : count]) <= 0.0
    assert early.labelled.sum() == 3 * count


def test_intervals_hold_the_errors():
    found = made_up()
    found.squares[0, :2] *= 1.5
    result = gap(found, SETTINGS)
    for low, high in result.before_interval_mm:
        assert 5.0 <= low < result.before_mm[0] < high <= 5.0 * np.sqrt(1.5)
    assert result.after_interval_mm == ((3.0, 3.0), (3.0, 3.0))
    assert result.reduction_mm[0] >= 2.0


def test_a_ball_without_air_lands_where_the_closed_form_says_if_in_time():
    found = landings(FALLING, DROPPED, np.array([1.0]))
    np.testing.assert_allclose(found.times, [FALL], rtol=1e-9)
    np.testing.assert_allclose(found.places, [[0.1 + 0.2 * FALL, 0.5 - FALL]], rtol=1e-9)
    found = landings(FALLING, np.repeat(DROPPED, 2, axis=0), np.array([FALL / 2, 1.0]))
    assert np.isnan(found.times).tolist() == [True, False]


def test_landings_have_the_errors_of_the_sensor():
    sensor = FALLING.amended("clock_rate", d=0.01).amended("position_scale", s=0.02)
    found = landings(sensor.amended("time_offset", tau=0.004), DROPPED, np.array([1.0]))
    np.testing.assert_allclose(found.times, [1.01 * (FALL + 0.004)], rtol=1e-9)
    np.testing.assert_allclose(found.places, [[1.02 * (0.1 + 0.2 * FALL), 1.02 * (0.5 - FALL)]])
    speed = np.linalg.norm([0.2, -1.0, 9.81 * FALL])
    with_speed = FALLING.amended("speed_dependent_latency", tau=0.001)
    found = landings(with_speed, DROPPED, np.array([1.0]))
    np.testing.assert_allclose(found.times, [FALL + 0.001 * speed], rtol=1e-9)


def test_draws_scatter_about_the_measured_errors_and_are_paired():
    # Errors before, after and at the floor, which shots share.
    common = np.random.default_rng(0).chisquare(2, (1, 60, 2))
    squares = common * np.array([9.0, 4.0, 1.0])[:, None, None]
    sizes, drawn = root_mean_squares(squares), resampled(squares, SETTINGS.verify.bootstrap_draws)
    assert drawn.mean(axis=0) == pytest.approx(sizes, rel=0.02)
    low, high = interval(drawn[:, 0, 0], 0.95)
    assert low < sizes[0, 0] < high
    assert drawn[:, 0] / drawn[:, 1] == pytest.approx(np.full((2000, 2), 1.5))
    squares[:, ::2, 1] = np.nan
    drawn = resampled(squares, SETTINGS.verify.bootstrap_draws)
    assert np.isfinite(drawn).all()
    assert drawn[:, :, 1].mean(axis=0) == pytest.approx(root_mean_squares(squares)[:, 1], rel=0.05)
