"""Motion: what a sensor sees, and exact derivatives of it."""

from dataclasses import replace

import numpy as np
import pytest

from rallygap.models.ball import sensor
from rallygap.models.ball.state import BALL_RADIUS
from rallygap.models.gap.fit.measurement import (
    KINK,
    Schedule,
    hypothesis_derivatives,
    nuisance_derivatives,
    predict_measurements,
)
from rallygap.models.gap.fit.trajectory import SLOW_SLIP
from rallygap.models.gap.hypotheses import Hypothesis, hypotheses
from tests.models.gap.hidden import NOMINAL, launches, measured

COUNT = 6
TIMES = np.arange(0.0, 0.6, 0.01)
MOMENTS = Schedule.of_times(np.tile(TIMES, (COUNT, 1)))
STATES = launches(COUNT, np.random.default_rng(3))
UNKNOWNS = np.hstack([STATES, np.zeros((COUNT, 3))])
DISTORTED = (
    NOMINAL.amended("clock_rate", d=0.01)
    .amended("position_scale", s=0.02)
    .amended("speed_dependent_latency", tau=5e-4)
    .amended("spin_gain", s=0.1)
    .amended("spin_axis_bias", x=0.05, y=-0.1, z=0.2)
)


def fourth_order(function, h):
    """The derivative at zero by five points."""
    return (8 * (function(h) - function(-h)) - (function(2 * h) - function(-2 * h))) / (12 * h)


def is_smooth(prediction):
    """Samples far enough from bounces that neither difference crosses one."""
    return prediction.is_smooth(MOMENTS.times, 30 * KINK)


@pytest.mark.parametrize("late", [0.0, 0.003])
def test_the_schedule_has_the_times_of_samples_and_labels(late):
    shots = measured(count=3, seconds=0.3)
    shots = replace(shots, label_times=shots.label_times + late)
    schedule = Schedule.of(shots)
    samples, labels = (
        np.take_along_axis(schedule.times, places, axis=1) + shots.times[:, :1]
        for places in (schedule.samples, schedule.labels)
    )
    assert samples == pytest.approx(shots.times, abs=1e-12)
    assert labels[shots.labelled] == pytest.approx(shots.label_times[shots.labelled], abs=1e-12)


def test_predictions_are_those_of_the_sensor_without_noise():
    positions, spins = sensor.measured(DISTORTED, STATES, TIMES, np.random.default_rng(0))
    prediction = predict_measurements(DISTORTED, MOMENTS, UNKNOWNS)
    assert prediction.positions == pytest.approx(positions, abs=1e-9)
    assert prediction.labels == pytest.approx(spins, abs=1e-7)


def test_a_kick_changes_the_rebound_and_conserves_angular_momentum_about_the_contact_point():
    apply_kicks = UNKNOWNS.copy()
    apply_kicks[:, 9:] = (0.02, 0.03, -0.01)
    change = (
        predict_measurements(NOMINAL, MOMENTS, apply_kicks).labels
        - predict_measurements(NOMINAL, MOMENTS, UNKNOWNS).labels
    )
    contacts = NOMINAL.fly(STATES, TIMES).contacts
    vx, vy, vz, wx, wy = contacts.before[:, 0, 3:8].T
    slip = np.stack([vx - BALL_RADIUS * wy, vy + BALL_RADIUS * wx], axis=1)
    along = slip / np.sqrt((slip**2).sum(axis=1, keepdims=True) + SLOW_SLIP**2)
    across = np.stack([-along[:, 1], along[:, 0]], axis=1)
    push = -vz[:, None] * (0.03 * along - 0.01 * across)
    # m r x dv + I dw = 0 with I = 2/3 m r^2 and the arm (0, 0, r)
    turn = 1.5 / BALL_RADIUS * np.stack([push[:, 1], -push[:, 0]], axis=1)
    last = (contacts.time[:, 1:2] > TIMES).sum(axis=1) - 1
    last = np.where(np.isnan(contacts.time[:, 1]), len(TIMES) - 1, last)
    assert change[np.arange(COUNT), last, :2] == pytest.approx(turn, abs=1e-6)


def test_derivatives_by_nuisance_parameters_agree_with_fourth_order_differences():
    prediction = predict_measurements(NOMINAL, MOMENTS, UNKNOWNS)
    slopes = nuisance_derivatives(NOMINAL, MOMENTS, UNKNOWNS, prediction).positions
    where = is_smooth(prediction)
    for column in range(UNKNOWNS.shape[1]):
        shift = np.eye(UNKNOWNS.shape[1])[column]
        exact = fourth_order(
            lambda h, shift=shift: (
                predict_measurements(NOMINAL, MOMENTS, UNKNOWNS + h * shift).positions
            ),
            2e-4,
        )
        error = np.abs(slopes[..., column] - exact)[where].max()
        assert error < 2e-4 * np.abs(exact).max()


@pytest.mark.parametrize(
    "hypothesis", hypotheses(NOMINAL), ids=lambda h: f"{h.effect}.{h.parameter}"
)
def test_derivatives_by_hypotheses_agree_with_other_differences(hypothesis):
    prediction = predict_measurements(NOMINAL, MOMENTS, UNKNOWNS)
    slopes = hypothesis_derivatives(NOMINAL, MOMENTS, UNKNOWNS, prediction, (hypothesis,))
    value, h = hypothesis.value(NOMINAL), 3 * hypothesis.step

    def at(shift):
        return predict_measurements(hypothesis.at(NOMINAL, value + shift), MOMENTS, UNKNOWNS)

    if value == hypothesis.declaration.bounds[0]:  # one side only, third order
        weights = {0: -11 / 6, 1: 3, 2: -3 / 2, 3: 1 / 3}
    else:
        weights = {-2: 1 / 12, -1: -2 / 3, 1: 2 / 3, 2: -1 / 12}
    views = {n: at(n * h) for n in weights}
    places = sum(w * views[n].positions for n, w in weights.items()) / h
    labels = sum(w * views[n].labels for n, w in weights.items()) / h
    where = is_smooth(prediction)
    assert slopes.positions[..., 0][where] == pytest.approx(
        places[where], abs=3e-4 * np.abs(places).max() + 1e-7
    )
    assert slopes.labels[..., 0][where] == pytest.approx(
        labels[where], abs=3e-4 * np.abs(labels[where]).max() + 1e-2
    )


def test_a_law_that_is_clipped_at_its_bound_has_its_whole_slope():
    still = NOMINAL.amended("drag", cd=0.0)
    here = predict_measurements(still, MOMENTS, UNKNOWNS)
    drag = (Hypothesis("drag", "cd"),)
    slope = hypothesis_derivatives(still, MOMENTS, UNKNOWNS, here, drag).positions[..., 0]
    ahead = predict_measurements(NOMINAL.amended("drag", cd=1e-4), MOMENTS, UNKNOWNS).positions
    where = is_smooth(here)
    expected = (ahead - here.positions)[where] / 1e-4
    assert slope[where] == pytest.approx(expected, abs=2e-3 * np.abs(expected).max())
