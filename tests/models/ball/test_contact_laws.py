"""Contacts against closed forms and conserved quantities."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from rallygap.models.ball.contact_laws import NET, ROLLING
from rallygap.models.ball.state import (
    BALL_MASS,
    BALL_RADIUS,
    NET_HEIGHT,
    TABLE_HALF_LENGTH,
    TABLE_HALF_WIDTH,
)
from tests.models.ball.balls import INERTIA, NOMINAL, energy, served_balls, simulator

RACKET = simulator(racket_bounce={"restitution": 0.878, "speed_loss": 0.02, "kp": 0.0019})
NET_PLAY = NOMINAL.amended("net", restitution=0.2, friction=0.5)
TIMES = np.arange(1, 161) * 0.005


def contact(ball, sim=NOMINAL):
    """State just before and just after the first contact."""
    contacts = sim.fly(ball, TIMES).contacts
    assert contacts.count[0] > 0
    return contacts.before[0, 0], contacts.after[0, 0]


def landing(ball):
    """The ball sent down onto the middle of its half, where it can only land."""
    low = np.array(ball)
    low[:3], low[5] = [0.0, 0.9, 0.1], -4.0
    return low


def angular_momentum(state, normal):
    """About the contact point."""
    orbital = BALL_MASS * BALL_RADIUS * np.cross(normal, state[3:6])
    return orbital + INERTIA * state[6:9]


@given(served_balls(), st.floats(0, 1), st.floats(0.05, 2), st.floats(0, 1))
@settings(max_examples=150)
def test_a_table_conserves_angular_momentum_gives_no_energy_and_limits_slip(
    ball, restitution, friction, elasticity
):
    table = NOMINAL.amended("table_bounce", restitution=restitution, friction=friction)
    before, after = contact(landing(ball), table.amended("tangential_elasticity", et=elasticity))
    up = np.array([0.0, 0.0, 1.0])
    np.testing.assert_allclose(
        angular_momentum(after, up), angular_momentum(before, up), rtol=1e-12, atol=1e-15
    )
    assert energy(after) <= energy(before) * (1 + 1e-14)

    def slip(s):
        return s[3:5] + BALL_RADIUS * np.array([-s[7], s[6]])

    left = slip(after) @ slip(before) / (slip(before) @ slip(before))
    assert -elasticity - 1e-9 <= left <= 1.0
    assert ROLLING * 2.5 == 1.0  # rolling takes the whole slip of a thin shell


def test_a_ball_that_leaves_the_racket_is_not_struck():
    before = np.array([0, 0, 1, 0.0, 5.0, 0.0, 100.0, 0, 0])
    np.testing.assert_array_equal(RACKET.strike(before, [0, 1, 0], [0, 0, 0])[0], before)


@pytest.mark.parametrize("beyond", [0.002, 0.010, 0.018])
def test_an_edge_ball_leaves_along_the_line_from_the_edge(beyond):
    ball = [0, TABLE_HALF_LENGTH + beyond, 0.3, 0, 0, -1.0, 0, 0, 0]
    before, after = contact(ball, NOMINAL.amended("table_bounce", friction=0.0))
    away, kick = before[:3] - [0, TABLE_HALF_LENGTH, 0], after[3:6] - before[3:6]
    assert np.linalg.norm(away) == pytest.approx(BALL_RADIUS)
    np.testing.assert_allclose(kick / np.linalg.norm(kick), away / BALL_RADIUS, atol=1e-9)


@pytest.mark.parametrize(
    "ball",
    [
        [0, TABLE_HALF_LENGTH + 0.021, 0.3, 0, 0, -1, 0, 0, 0],
        [TABLE_HALF_WIDTH + 0.021, 0.5, 0.3, 0, 0, -1, 0, 0, 0],
        [0, 0.4, 0.25, 0, -6, 1, 0, 0, 0],
        [0.95, 0.4, 0.1, 0, -6, 1, 0, 0, 0],
    ],
    ids=["behind the table", "beside the table", "over the net", "beside the net"],
)
def test_a_ball_that_passes_a_surface_touches_nothing(ball):
    assert NET_PLAY.fly(ball, TIMES[:20]).contacts.count[0] == 0


def test_a_ball_from_below_bounces_off_the_underside():
    before, after = contact([0.2, 0.4, -0.2, 0, 0, 5.0, 0, 0, 0])
    assert before[2] == pytest.approx(-BALL_RADIUS)
    assert after[5] == pytest.approx(-0.93 * before[5])


def test_a_ball_on_the_cord_hops_over():
    flight = NET_PLAY.fly([0, 0.4, NET_HEIGHT + 0.012, 0, -6, 0.35, 0, 0, 0], TIMES)
    assert flight.contacts.surface[0, 0] == NET
    assert flight.contacts.after[0, 0, 5] > flight.contacts.before[0, 0, 5]
    assert flight.states[0, -1, 1] < 0
