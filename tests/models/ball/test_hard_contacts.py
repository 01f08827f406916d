"""Balls that rest, slide, start inside a surface or meet two at once; values at the bounds."""

import subprocess
import sys

import numpy as np
import pytest

from rallygap.models.ball.contact_laws import NET
from rallygap.models.ball.sensor import measured
from rallygap.models.ball.state import BALL_RADIUS, TABLE_HALF_LENGTH
from tests.models.ball.balls import NOMINAL, energy, simulator

TIMES = np.arange(1, 101) * 0.005
PLAY = NOMINAL.amended("net", restitution=0.2, friction=0.5)
DEAD = simulator(
    gravity={"g": 9.81},
    table_bounce={"restitution": 0.0, "friction": 0.0},
    net={"restitution": 0.2, "friction": 0.0},
)


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


def test_a_ball_rising_inside_the_table_is_not_pushed():
    ball = np.array([0, 0.5, 0.005, 0, -0.2, 0.02, 0, 0, 0])
    total = energy(np.vstack([ball, NOMINAL.fly(ball, TIMES).states[0]]), g=9.81)
    assert (np.diff(total) <= 1e-12).all()


def test_a_ball_leaving_the_edge_is_not_pulled_back():
    ball = [0, TABLE_HALF_LENGTH + 0.015, 0.005, 0, 5, -1, 0, 0, 0]
    assert PLAY.fly(ball, TIMES).contacts.count[0] == 0
    assert PLAY.fly(ball, [0.005]).states[0, 0, 4] > 4.9


def test_a_ball_measured_inside_the_net_bounces_at_once():
    assert PLAY.fly([0, 0.002, 0.1, 0, -10, 0, 0, 0, 0], [0.02]).states[0, 0, 1] > 0.002


def test_an_edge_grazed_between_two_looks_deflects_the_ball():
    grazing = simulator(table_bounce={"restitution": 0.9, "friction": 0.2})
    heights = BALL_RADIUS - 1e-4
    balls = [[0, 1.37 + 0.1 + d, heights, 0, -20, 0, 0, 0, 0] for d in np.linspace(0, 0.1, 41)]
    # From outside, level, a tenth of a millimetre too low: each hits the edge a little.
    assert (grazing.fly(balls, TIMES[:8]).contacts.count == 1).all()


def test_the_net_stands_on_the_table():
    low = PLAY.amended("table_height", h=-0.2).amended("gravity", g=0.0)
    contacts = low.fly([0, 0.3, -0.1, 0, -9, 0, 0, 0, 0], TIMES[:8]).contacts
    assert contacts.surface[0, 0] == NET


def test_drag_never_drives_the_ball():
    fast = NOMINAL.amended("speed_dependent_drag", c=-0.5)
    speed = np.linalg.norm(fast.fly([0, 1, 3, 0, -35, 0, 0, 0, 0], TIMES).states[0, :, 3:5], axis=1)
    np.testing.assert_allclose(speed, 35.0)


def test_friction_has_no_grip_below_zero():
    slippery = NOMINAL.amended("slip_dependent_friction", c=-0.2)
    contacts = slippery.fly([0, 1, 0.3, 0, -9.8, -5, 0, 0, 0], TIMES).contacts
    assert contacts.count[0] > 0
    np.testing.assert_allclose(contacts.after[0, 0, 3:5], contacts.before[0, 0, 3:5])


def test_effects_at_their_bounds_neither_make_nor_remove_a_surface():
    floating = simulator(gravity={"g": 9.81}, spin_dependent_restitution={"c": -0.1})
    assert floating.fly([0, 1, 0.3, 0, 0, 0, 0, 0, 0], TIMES).contacts.count[0] == 0
    dead = simulator(racket_bounce={"restitution": 0.1, "speed_loss": 0.1, "kp": 0.0})
    after = dead.strike([0, 0, 1, 0, -30, 0, 0, 0, 0], [0, 2, 0], [0, 0, 0])[0]
    assert after[4] == pytest.approx(0.0)


@pytest.mark.parametrize("normals", [[[0, 1, 0]], [[0, 1]] * 2, [[0, 0, 0], [0, 1, 0]]])
@pytest.mark.filterwarnings("ignore:invalid value")
def test_rackets_that_do_not_fit_the_balls_are_refused(normals):
    with pytest.raises(ValueError, match=r"give states|finite"):
        PLAY.strike(np.zeros((2, 9)), normals, np.zeros((2, 3)))


def test_latency_shows_the_past_even_where_the_ball_slows_down():
    ball, tau = np.array([0, 1.0, 0.1, 0, -20.0, -10.0, 0, 0, 0]), -0.002
    positions, _ = measured(
        NOMINAL.amended("speed_dependent_latency", tau=tau),
        ball[None],
        TIMES,
        np.random.default_rng(0),
    )
    speed = np.linalg.norm(NOMINAL.fly(ball, TIMES).states[0, :, 3:6], axis=1)
    seen_at = TIMES - tau * speed
    assert (np.diff(seen_at) < 0).any()
    expected = [NOMINAL.fly(ball, [moment]).states[0, 0, :3] for moment in seen_at]
    np.testing.assert_allclose(positions[0], expected, atol=1e-6)


def test_tiny_steps_add_up():
    times = np.arange(1, 2001) * 1e-12
    end = NOMINAL.fly([0, 1, 1, 0, -30, 0, 0, 0, 0], times).states[0, -1]
    assert end[1] - 1 == pytest.approx(-30 * 2e-9, rel=1e-4)


def test_a_flight_at_absurd_speed_comes_to_its_end():
    """A fit that is far off may ask for it."""
    states = DEAD.fly([0, 1, 0.1, 0, -1e12, 0, 0, 0, 0], TIMES).states
    assert states[0, -1, 1] == pytest.approx(1 - 1e12 * TIMES[-1])


def test_a_simulator_is_described_without_numba():
    program = "import sys, rallygap.models.ball.simulator; sys.exit('numba' in sys.modules)"
    assert subprocess.run([sys.executable, "-c", program], check=False).returncode == 0
