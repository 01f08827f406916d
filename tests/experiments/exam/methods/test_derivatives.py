"""The library of regression terms, against the equations of motion written by hand."""

import numpy as np
import pytest

from experiments.exam.methods.derivatives import library, rates
from rallygap.models.ball.state import DRAG_FACTOR, MAGNUS_FACTOR, SPIN, VELOCITY
from rallygap.models.gap.hypotheses import Hypothesis
from tests.experiments.exam.example_trials import NOMINAL

STATES = np.array([[0.1, -1.0, 0.5, 0.8, 6.0, 1.5, 150.0, -80.0, 40.0]])
FREE = NOMINAL.without_surfaces()
V, W = STATES[0, VELOCITY], STATES[0, SPIN]
LIFT = MAGNUS_FACTOR * 0.069 * np.cross(W, V)
DRAG = -DRAG_FACTOR * 0.54 * np.linalg.norm(V) * V


def term(effect, parameter):
    return library(FREE, STATES, 0.0, (Hypothesis(effect, parameter),)).terms[0, :, 0]


def test_rates_are_those_of_the_equations_of_motion():
    expected = np.concatenate([LIFT + DRAG + [0.0, 0.0, -9.81], np.zeros(3)])
    assert rates(FREE, STATES)[0] == pytest.approx(expected, abs=1e-3)


def test_parameters_change_rates_by_their_forces():
    assert term("drag", "cd")[:3] == pytest.approx(DRAG / 0.54, rel=1e-3)
    assert term("gravity", "g")[:3] == pytest.approx([0.0, 0.0, -1.0], abs=1e-4)
    decay = np.concatenate([np.zeros(3), -np.linalg.norm(V) * W])
    assert term("spin_decay", "c") == pytest.approx(decay, rel=1e-3, abs=1e-2)
    # Labels that read high look like too little lift.
    assert term("spin_gain", "s")[:3] == pytest.approx(-LIFT, rel=1e-3)


def test_a_slow_clock_changes_accelerations_and_what_speeds_explain_of_them():
    # a_m = a(v) / (1 + d)^2 and v = (1 + d) v_m: -2 a, plus 2 of drag and 1 of lift.
    expected = -2 * np.array([0.0, 0.0, -9.81]) - LIFT
    assert term("clock_rate", "d")[:3] == pytest.approx(expected, rel=1e-3, abs=2e-3)


def test_a_height_raises_a_ball_after_its_bounce_by_what_it_gains_both_ways():
    falling = np.array([[0.0, 0.8, 0.035, 0.0, 4.0, -3.0, 0.0, 0.0, 0.0]])
    found = library(NOMINAL, falling, 0.01, (Hypothesis("table_height", "h"),))
    assert np.isfinite(found.contacts).sum() == 1
    # Less what gravity does to it in the few milliseconds around.
    assert found.terms[0, 2, 0] == pytest.approx(1.93, abs=0.04)
