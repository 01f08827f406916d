"""Contacts: in order of time, on their surfaces, and known until the ball is out of view."""

import numpy as np
import pytest

from rallygap.models.arena.contacts import (
    FLOOR,
    FLOOR_SURFACE,
    bounce_off_floor,
    follow_contacts,
    in_view,
)
from rallygap.models.ball.contact_laws import TABLE
from rallygap.models.ball.state import BALL_RADIUS
from tests.models.arena.sessions import TRUTH, flying
from tests.models.ball.balls import energy


def followed(states, most=5, seed=0):
    return follow_contacts(TRUTH, np.atleast_2d(states), most, np.random.default_rng(seed))


def test_a_dropped_ball_bounces_lower_and_lower_on_the_table_and_beside_it_on_the_floor():
    flight = followed([0.3, 0.8, 0.3, 0, 0, 0, 0, 0, 0])
    assert (flight.surfaces == TABLE).all()
    assert flight.times[0, 0] == pytest.approx(np.sqrt(2 * 0.28 / 9.81), rel=0.02)
    assert (np.diff(flight.states[0, :, 5]) < 0).all()
    assert np.abs(flight.states[0, :, 2] - BALL_RADIUS).max() < 0.02  # height and tilt of the table

    flight = followed([1.5, 0.0, 0.3, 0, 1.0, 0, 0, 0, 0], most=2)
    assert (flight.surfaces == FLOOR_SURFACE).all()
    assert flight.states[0, :, 2] == pytest.approx([FLOOR + BALL_RADIUS] * 2, abs=1e-9)
    fall = 0.3 - FLOOR - BALL_RADIUS
    assert flight.times[0, 0] == pytest.approx(np.sqrt(2 * fall / 9.81), rel=0.03)


def test_a_ball_that_flies_off_is_gone_when_it_leaves_the_cameras_sight():
    flight = followed([0.0, 0.0, 1.0, 0, 10.0, 0, 0, 0, 0])

    assert np.isinf(flight.times).all()
    end = TRUTH.simulator.fly(
        [0, 0, 1, 0, 10, 0, 0, 0, 0], [flight.last_visible[0], flight.last_visible[0] + 0.02]
    )
    assert in_view(end.states[0]).tolist() == [True, False]


def test_the_floor_takes_energy_and_turns_a_sliding_ball():
    before = flying(500, np.random.default_rng(0))

    after = bounce_off_floor(before)

    assert (energy(after) < energy(before)).all()
    slid = bounce_off_floor(np.array([[0, 0, FLOOR, 0, 5.0, -1.0, 0, 0, 0]]))[0]
    assert slid[4] < 5.0
    assert slid[6] < 0  # forward roll along +y
