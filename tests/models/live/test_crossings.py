"""Crossings on a path agree with the simulator's contacts and with closed forms."""

import numpy as np
import pytest

from rallygap.models.ball.simulator import Simulator
from rallygap.models.ball.simulators import shipped
from rallygap.models.ball.state import BALL_RADIUS
from rallygap.models.live.crossings import apex, bounce, plane
from rallygap.models.live.forecaster import Forecaster
from rallygap.models.predictors.sensor import Sensor

TRUTH = shipped("literature")
VACUUM = Simulator.from_dict({"gravity": {"g": 9.81}})
STEP = 0.005
TIMES = STEP * np.arange(160)
THROWN = np.array([0.0, 0.5, 0.3, 1.0, -4.0, 2.0, 0.0, 0.0, 0.0])
ACROSS = np.array([0.0, -1.0, 0.0]), np.array([0.0, 2.0, 0.0])


def flown(simulator, first=THROWN):
    return simulator.fly(first, TIMES).states[0]


def time_of(crossing):
    return TIMES[crossing.row] + crossing.after


def test_the_bounce_is_the_simulators_contact():
    contacts = TRUTH.fly(THROWN, TIMES).contacts
    found = bounce(flown(TRUTH), Sensor(TRUTH))
    assert time_of(found) == pytest.approx(contacts.time[0, 0], abs=2e-5)
    assert found.state == pytest.approx(contacts.before[0, 0], abs=0.02)
    assert found.state[2] == pytest.approx(BALL_RADIUS)


def test_the_apex_is_where_a_thrown_ball_stops_rising():
    found = apex(flown(VACUUM), STEP)
    assert time_of(found) == pytest.approx(2.0 / 9.81, abs=1e-6)
    assert found.state[2] == pytest.approx(0.3 + 2.0**2 / (2 * 9.81), abs=1e-4)


def test_a_plane_is_crossed_where_the_closed_form_says():
    found = plane(flown(VACUUM), STEP, *ACROSS)
    assert time_of(found) == pytest.approx(1.5 / 4.0)
    assert found.state[:2] == pytest.approx([0.375, -1.0])
    # The error of the time is that of the place over the speed.
    assert found.time_error(0.01**2 * np.eye(9)) == pytest.approx(0.01 / 4.0)


def test_what_does_not_happen_on_the_path_is_none():
    falling = flown(VACUUM, THROWN * [1, 1, 1, 1, 1, -1, 1, 1, 1])
    assert apex(falling, STEP) is None
    assert bounce(falling, Sensor(VACUUM)) is None  # without a table
    assert plane(falling, STEP, np.array([0.0, 5.0, 0.0]), np.eye(3)[1]) is None


def test_a_forecaster_has_them_with_their_errors():
    forecaster = Forecaster(TRUTH)
    assert forecaster.bounce() is None
    flight = TRUTH.fly(THROWN, TIMES)
    for k in range(30):
        forecaster.observe(7.0 + TIMES[k], flight.states[0, k, :3])
    for event, true in (
        (forecaster.bounce(), 7.0 + flight.contacts.time[0, 0]),
        (forecaster.apex(), 7.0 + time_of(apex(flown(TRUTH), STEP))),
        (forecaster.crossing(*ACROSS), 7.0 + time_of(plane(flown(TRUTH), STEP, *ACROSS))),
    ):
        assert abs(event.time - true) < 3 * event.time_error < 0.06
        assert (np.linalg.eigvalsh(event.covariance) > -1e-9).all()
