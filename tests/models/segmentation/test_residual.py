"""Residuals of a flight, with and without a missed contact."""

import numpy as np
from scipy.integrate import solve_ivp

from rallygap.models.segmentation.cuts import flight_residuals
from rallygap.models.segmentation.flight import DRAG

T = 0.005 * np.arange(100)
ALL = np.ones(100, dtype=bool)


def flown(lift=(0.0, 2.0, -9.81 - 3.0)):
    def motion(_, state):
        return [*state[3:], *(lift - DRAG * np.linalg.norm(state[3:]) * state[3:])]

    begin = [0, -1, 0.3, 0.5, 6.0, 2.0]
    states = solve_ivp(motion, (0, 0.5), begin, t_eval=T, rtol=1e-10, atol=1e-12).y.T
    return states[:, :3], states[:, 3:]


def test_flight_with_drag_and_constant_lift_has_no_residual():
    assert flight_residuals(T, *flown(), ALL).max() < 1e-4


def test_missed_contact_has_a_residual_of_centimetres():
    x, velocity = flown()
    x[50:] += (T[50:, None] - T[50]) * [0, -1.0, 4.0]
    assert np.sqrt(np.mean(flight_residuals(T, x, velocity, ALL) ** 2)) > 0.03


def test_outlier_has_a_residual_and_does_not_affect_the_fit():
    x, velocity = flown()
    x[40] += [0.0, 0.3, 0.4]
    errors = flight_residuals(T, x, velocity, np.arange(100) != 40)
    np.testing.assert_allclose(errors, np.where(np.arange(100) == 40, 0.5, 0), atol=1e-4)
