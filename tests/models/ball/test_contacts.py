"""Contacts against closed forms and conserved quantities, hard ones too.

Balls that rest, slide, start inside a surface or meet two at once; values at the bounds.
"""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from rallygap.models.ball.contact_laws import NET
from rallygap.models.ball.sensor import measured
from rallygap.models.ball.state import (
    BALL_MASS,
    BALL_RADIUS,
    NET_HEIGHT,
    TABLE_HALF_LENGTH,
    TABLE_HALF_WIDTH,
)
from tests.models.ball.balls import (
    INERTIA,
    NET_PLAY,
    NOMINAL,
    RACKET,
    energy,
    served_balls,
    simulator,
)

TIMES = np.arange(1, 101) * 0.005
DEAD = simulator(
    gravity={"g": 9.81},
    table_bounce={"restitution": 0.0, "friction": 0.0},
    net={"restitution": 0.2, "friction": 0.0},
)


def contact(ball, sim=NOMINAL):
    """State just before and just after the first contact."""
    contacts = sim.fly(ball, TIMES).contacts
    assert contacts.count[0] > 0
    return contacts.before[0, 0], contacts.after[0, 0]


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
    ball[:3], ball[5] = [0.0, 0.9, 0.1], -4.0  # down onto the middle of its half
    before, after = contact(ball, table.amended("tangential_elasticity", et=elasticity))
    up = np.array([0.0, 0.0, 1.0])
    np.testing.assert_allclose(
        angular_momentum(after, up), angular_momentum(before, up), rtol=1e-12, atol=1e-15
    )
    assert energy(after) <= energy(before) * (1 + 1e-14)

    def slip(s):
        return s[3:5] + BALL_RADIUS * np.array([-s[7], s[6]])

    left = slip(after) @ slip(before) / (slip(before) @ slip(before))
    assert -elasticity - 1e-9 <= left <= 1.0


def test_a_ball_that_leaves_the_racket_is_not_struck():
    before = np.array([0, 0, 1, 0.0, 5.0, 0.0, 100.0, 0, 0])
    struck = simulator(racket_bounce=RACKET).strike(before, [0, 1, 0], [0, 0, 0])[0]
    np.testing.assert_array_equal(struck, before)


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
    ids=["behind the table", "next to the table", "over the net", "next to the net"],
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


def test_a_resting_ball_does_not_slide_through_the_net():
    flight = DEAD.fly([0, 1, BALL_RADIUS, 0, -12, 0, 0, 0, 0], TIMES)
    assert (flight.states[0, :, 1] >= BALL_RADIUS - 1e-9).all()
    first = flight.contacts.surface[0].tolist().index(NET)
    assert flight.contacts.after[0, first, 4] == pytest.approx(0.2 * 12)


def test_a_ball_pressed_into_the_corner_of_net_and_table_stays_there():
    corner = [0.2, BALL_RADIUS + 1e-6, BALL_RADIUS + 1e-4, 0, -0.01, 0, 0, 0, 0]
    states = DEAD.amended("wind", y=-5).amended("drag", cd=0.5).fly(corner, TIMES).states[0]
    assert (states[:, 1:3] >= BALL_RADIUS - 1e-9).all()


def test_a_ball_sliding_up_a_tilted_table_slows_down():
    uphill = DEAD.amended("table_tilt", y=-0.1)
    away = BALL_RADIUS * np.hypot(np.sin(0.1), 1.0)
    ball = np.array([0, -0.9, away - 0.9 * np.sin(0.1), 0, 0.8, 0.08, 0, 0, 0])
    total = energy(uphill.fly(ball, TIMES[:60]).states[0], g=9.81)
    np.testing.assert_allclose(total, total[-1], rtol=1e-4)
    assert (np.diff(total) <= 1e-12).all()


@pytest.mark.parametrize("depth", [0.002, 0.018, 0.022, 0.026])
def test_a_slow_ball_measured_inside_the_table_does_not_fall_through(depth):
    ball = [0, 0.5, BALL_RADIUS - depth, 0, -0.2, -0.1, 0, 0, 0]
    assert (NOMINAL.fly(ball, TIMES).states[0, :, 2] > -0.01).all()


def test_a_ball_rising_inside_the_table_or_leaving_its_edge_is_not_pushed_or_pulled_back():
    ball = np.array([0, 0.5, 0.005, 0, -0.2, 0.02, 0, 0, 0])
    total = energy(np.vstack([ball, NOMINAL.fly(ball, TIMES).states[0]]), g=9.81)
    assert (np.diff(total) <= 1e-12).all()
    ball = [0, TABLE_HALF_LENGTH + 0.015, 0.005, 0, 5, -1, 0, 0, 0]
    assert NET_PLAY.fly(ball, TIMES).contacts.count[0] == 0
    assert NET_PLAY.fly(ball, [0.005]).states[0, 0, 4] > 4.9


def test_a_ball_measured_inside_the_net_bounces_at_once():
    assert NET_PLAY.fly([0, 0.002, 0.1, 0, -10, 0, 0, 0, 0], [0.02]).states[0, 0, 1] > 0.002


def test_an_edge_grazed_between_two_looks_deflects_the_ball():
    grazing = simulator(table_bounce={"restitution": 0.9, "friction": 0.2})
    heights = BALL_RADIUS - 1e-4
    balls = [[0, 1.37 + 0.1 + d, heights, 0, -20, 0, 0, 0, 0] for d in np.linspace(0, 0.1, 41)]
    # From outside, level, a tenth of a millimetre too low: each hits the edge a little.
    assert (grazing.fly(balls, TIMES[:8]).contacts.count == 1).all()


def test_the_net_stands_on_the_table():
    low = NET_PLAY.amended("table_height", h=-0.2).amended("gravity", g=0.0)
    contacts = low.fly([0, 0.3, -0.1, 0, -9, 0, 0, 0, 0], TIMES[:8]).contacts
    assert contacts.surface[0, 0] == NET


def test_effects_at_their_bounds_neither_drive_nor_grip_and_neither_make_nor_remove_a_surface():
    fast = NOMINAL.amended("speed_dependent_drag", c=-0.5)
    speed = np.linalg.norm(fast.fly([0, 1, 3, 0, -35, 0, 0, 0, 0], TIMES).states[0, :, 3:5], axis=1)
    np.testing.assert_allclose(speed, 35.0)
    slippery = NOMINAL.amended("slip_dependent_friction", c=-0.2)
    contacts = slippery.fly([0, 1, 0.3, 0, -9.8, -5, 0, 0, 0], TIMES).contacts
    assert contacts.count[0] > 0
    np.testing.assert_allclose(contacts.after[0, 0, 3:5], contacts.before[0, 0, 3:5])
    floating = simulator(gravity={"g": 9.81}, spin_dependent_restitution={"c": -0.1})
    assert floating.fly([0, 1, 0.3, 0, 0, 0, 0, 0, 0], TIMES).contacts.count[0] == 0
    dead = simulator(racket_bounce={"restitution": 0.1, "speed_loss": 0.1, "kp": 0.0})
    after = dead.strike([0, 0, 1, 0, -30, 0, 0, 0, 0], [0, 2, 0], [0, 0, 0])[0]
    assert after[4] == pytest.approx(0.0)


@pytest.mark.parametrize("normals", [[[0, 1, 0]], [[0, 1]] * 2, [[0, 0, 0], [0, 1, 0]]])
@pytest.mark.filterwarnings("ignore:invalid value")
def test_rackets_that_do_not_fit_the_balls_are_refused(normals):
    with pytest.raises(ValueError, match=r"give states|finite"):
        NET_PLAY.strike(np.zeros((2, 9)), normals, np.zeros((2, 3)))


def test_latency_shows_the_past_even_where_the_ball_slows_down():
    ball, tau = np.array([0, 1.0, 0.1, 0, -20.0, -10.0, 0, 0, 0]), -0.002
    late = NOMINAL.amended("speed_dependent_latency", tau=tau)
    positions, _ = measured(late, ball[None], TIMES, np.random.default_rng(0))
    speed = np.linalg.norm(NOMINAL.fly(ball, TIMES).states[0, :, 3:6], axis=1)
    seen_at = TIMES - tau * speed
    assert (np.diff(seen_at) < 0).any()
    expected = [NOMINAL.fly(ball, [moment]).states[0, 0, :3] for moment in seen_at]
    np.testing.assert_allclose(positions[0], expected, atol=1e-6)


def test_tiny_steps_add_up_and_a_flight_at_absurd_speed_comes_to_its_end():
    times = np.arange(1, 2001) * 1e-12
    end = NOMINAL.fly([0, 1, 1, 0, -30, 0, 0, 0, 0], times).states[0, -1]
    assert end[1] - 1 == pytest.approx(-30 * 2e-9, rel=1e-4)
    # A fit that is far off may ask for it.
    states = DEAD.fly([0, 1, 0.1, 0, -1e12, 0, 0, 0, 0], TIMES).states
    assert states[0, -1, 1] == pytest.approx(1 - 1e12 * TIMES[-1])
