"""The independent ball agrees with DOP853, and with the simulator where nothing is hidden."""

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from experiments.exam.simulate.independent_ball import IndependentBall
from experiments.exam.simulate.laws import bounce, derivative, normal_of, physics_of
from rallygap.models.ball.state import BALL_RADIUS
from tests.experiments.exam.example_trials import NOMINAL, drawn

PHYSICS = physics_of(NOMINAL)
RICH = PHYSICS._replace(
    speed_dependent_drag_c=-0.1,
    spin_dependent_drag_c=0.1,
    lift_saturation_kappa=2.0,
    lift_crisis_d=0.5,
    spin_decay_c=0.02,
    wind_x=0.3,
    wind_y=-0.4,
    side_force_cy=0.03,
    frame_tilt_y=0.01,
    slip_dependent_friction_c=0.01,
    speed_dependent_restitution_c=0.02,
    table_height_h=0.01,
    table_tilt_x=0.005,
)


def dop853(state, times, physics):
    """States at ``times`` by scipy, with the touch as an event."""

    def slope(_time, y):
        result = np.empty(9)
        derivative(y, physics, result)
        return result

    def touch(_time, y):
        return np.dot(normal_of(physics), y[:3] - [0, 0, physics.table_height_h]) - BALL_RADIUS

    touch.terminal, touch.direction = True, -1
    states, now = [], 0.0
    while True:
        ahead = times[times > now]
        found = solve_ivp(
            slope, (now, times[-1]), state, "DOP853", ahead, events=touch, rtol=1e-11, atol=1e-11
        )
        states.extend(found.y.T if len(ahead) else [])
        if found.status == 0:
            return np.array(states)
        now, state = found.t_events[0][0], found.y_events[0][0].copy()
        bounce(state, physics)


@pytest.mark.parametrize("physics", [PHYSICS, RICH])
def test_it_agrees_with_dop853(physics):
    launches = drawn(shots=8, seed=5)

    for state, duration in zip(launches.states, launches.durations, strict=True):
        times = np.linspace(duration / 30, duration, 30)
        flown = IndependentBall(physics).fly(state, times).states[0]
        assert flown[:, :3] == pytest.approx(dop853(state, times, physics)[:, :3], abs=1e-6)


def test_with_nothing_hidden_it_agrees_with_the_simulator():
    launches = drawn(shots=300)
    times = launches.durations[:, None] * np.linspace(0, 1, 40)

    ours = IndependentBall(PHYSICS).fly(launches.states, times)
    theirs = NOMINAL.fly(launches.states, times)

    assert np.abs(ours.states - theirs.states)[..., :3].max() < 1e-6
    assert (ours.contacts.count == theirs.contacts.count).all()
    assert ours.contacts.time == pytest.approx(theirs.contacts.time, abs=1e-7, nan_ok=True)


def test_a_falling_ball_bounces_in_closed_form():
    physics = PHYSICS._replace(drag_cd=0.0, magnus_cm=0.0)
    fall = np.sqrt(2 * 0.3 / 9.81)
    start = [0, 0.5, BALL_RADIUS + 0.3, 0, 0, 0, 0, 0, 0]

    flight = IndependentBall(physics).fly(start, [0.0, fall + 0.1])

    height = BALL_RADIUS + 0.93 * 9.81 * fall * 0.1 - 9.81 / 2 * 0.1**2
    assert flight.contacts.time[0, 0] == pytest.approx(fall, abs=1e-12)
    assert flight.states[0, 1, 2] == pytest.approx(height, abs=1e-10)


def test_times_before_the_launch_are_free_flight_and_balls_past_the_edge_do_not_bounce():
    state = [0, 0, 0.5, 1, -5, 1, 50, 20, 10]
    ball = IndependentBall(PHYSICS)
    earlier = ball.fly(state, [-0.03, 0.0]).states[0]
    assert earlier[1] == pytest.approx(state, abs=1e-15)
    assert ball.fly(earlier[0], [0.03]).states[0, 0] == pytest.approx(state, abs=1e-9)

    beside = ball.fly([0.9, 0, 0.1, 0, 0, -1, 0, 0, 0], [0.3])
    assert beside.contacts.count[0] == 0
    assert beside.states[0, 0, 2] < 0
