"""Events on a path agree with the simulator's contacts and with closed forms."""

import numpy as np
import pytest

from models.ball.simulator import Simulator
from models.ball.simulators import shipped
from models.ball.state import BALL_RADIUS
from models.live.forecast_path import ForecastPath

TRUTH = shipped("literature")
VACUUM = Simulator.from_dict({"gravity": {"g": 9.81}})
TIMES = 0.005 * np.arange(160)
THROWN = np.array([0.0, 0.5, 0.3, 1.0, -4.0, 2.0, 0.0, 0.0, 0.0])


def path(simulator, first=THROWN, variance=0.0):
    covariances = np.tile(variance * np.eye(9), (len(TIMES), 1, 1))
    return ForecastPath(10.0 + TIMES, simulator.fly(first, TIMES).states[0], covariances)


def test_the_bounce_is_the_simulators_contact():
    flight = TRUTH.fly(THROWN, TIMES)
    found = path(TRUTH).bounce()
    assert found.time == pytest.approx(10.0 + flight.contacts.time[0, 0], abs=2e-5)
    assert found.state == pytest.approx(flight.contacts.before[0, 0], abs=0.02)
    assert found.state[2] == BALL_RADIUS


def test_the_apex_is_where_a_thrown_ball_stops_rising():
    found = path(VACUUM).apex()
    assert found.time == pytest.approx(10.0 + 2.0 / 9.81, abs=1e-6)
    assert found.state[2] == pytest.approx(0.3 + 2.0**2 / (2 * 9.81), abs=1e-4)


def test_a_plane_is_crossed_where_the_closed_form_says():
    found = path(VACUUM).crossing(np.array([0.0, -1.0, 0.0]), np.array([0.0, 2.0, 0.0]))
    assert found.time == pytest.approx(10.0 + 1.5 / 4.0)
    assert found.state[:2] == pytest.approx([0.375, -1.0])


def test_the_error_of_a_time_is_that_of_the_place_over_the_speed():
    found = path(VACUUM, variance=0.01**2).crossing(np.array([0.0, -1.0, 0.0]), np.eye(3)[1])
    assert found.time_error == pytest.approx(0.01 / 4.0)


def test_what_does_not_happen_on_the_path_is_none():
    falling = path(VACUUM, THROWN * [1, 1, 1, 1, 1, -1, 1, 1, 1])
    assert falling.apex() is None
    assert falling.bounce() is None  # without a table
    assert falling.crossing(np.array([0.0, 5.0, 0.0]), np.eye(3)[1]) is None
