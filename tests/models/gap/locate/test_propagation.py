"""Propagation of perturbations, against exact flights."""

import numpy as np
import pytest

from rallygap.models.ball.state import SPIN, VELOCITY
from rallygap.models.gap.fit.measurement import KINK, Schedule, predict_measurements
from rallygap.models.gap.locate.propagation import after_forcing, after_jump, arcs
from tests.models.gap.hidden import NOMINAL, launches

TIMES = np.arange(0.0, 0.7, 0.005)
COUNT = 5
STATES = launches(COUNT, np.random.default_rng(1))
SCHEDULE = Schedule.of_times(np.tile(TIMES, (COUNT, 1)))
ARCS = arcs(NOMINAL, STATES, SCHEDULE.times)
PATH = NOMINAL.fly(STATES, TIMES)
PREDICTION = predict_measurements(NOMINAL, SCHEDULE, STATES)
AWAY = PREDICTION.is_smooth(SCHEDULE.times, 0.006)


def test_every_time_away_from_bounces_is_within_one_arc():
    covered = np.zeros(SCHEDULE.times.shape)
    for arc in ARCS:
        covered[arc.rows] += arc.inside
    assert np.all(covered[PREDICTION.is_smooth(SCHEDULE.times, 2 * KINK)] == 1)
    assert np.all(covered <= 1)
    first = ARCS[0].inside
    assert ARCS[0].states[first] == pytest.approx(PATH.states[first])


def test_a_loss_of_spin_propagates_through_bounces():
    h = 1e-3
    exact = (NOMINAL.amended("spin_decay", c=h).fly(STATES, TIMES).states - PATH.states) / h
    forcing = np.zeros((*PATH.states.shape, 1))
    speed = np.linalg.norm(PATH.states[..., VELOCITY], axis=-1, keepdims=True)
    forcing[..., SPIN, 0] = -speed * PATH.states[..., SPIN]
    change = after_forcing(ARCS, forcing)[..., SPIN, 0]
    largest = np.abs(exact[..., SPIN]).max()
    assert change[AWAY] == pytest.approx(exact[AWAY][:, SPIN], abs=0.02 * largest)


def test_a_jump_at_a_bounce_propagates_like_another_rebound():
    jump = np.array([0.0, 0.0, 0.0, 1.0, -0.5, 0.0, 0.0, 20.0, 0.0])
    jumps = np.tile(jump, (COUNT, 1))[..., None]
    change = after_jump(ARCS, 0, jumps, len(TIMES))[..., 0]
    h, after = 1e-4, PATH.contacts.after[:, 0]
    since = TIMES - PATH.contacts.time[:, :1]
    flights = [
        NOMINAL.fly(after + sign * h * jump, np.maximum(since, 0.0)).states for sign in (1, -1)
    ]
    exact = np.where(since[..., None] > 0.0, (flights[0] - flights[1]) / (2 * h), 0.0)
    assert change[AWAY] == pytest.approx(exact[AWAY], abs=0.01 * np.abs(exact).max())


def test_a_missing_bounce_changes_nothing():
    assert not after_jump(ARCS, len(ARCS), np.ones((COUNT, 9, 2)), len(TIMES)).any()
