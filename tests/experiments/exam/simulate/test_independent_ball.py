"""The independent ball: closed forms, conserved quantities, DOP853 and the simulator."""

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from experiments.exam.simulate.independent_ball import IndependentBall
from experiments.exam.simulate.laws import bounce, derivative, normal_of, physics_of
from rallygap.models.ball.state import BALL_MASS, BALL_RADIUS
from tests.experiments.exam.example_trials import NOMINAL, drawn
from tests.models.ball.balls import energy
from tests.models.ball.reference import Physics as Reference

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


def incoming():
    random = np.random.default_rng(0)
    states = np.zeros((200, 9))
    states[:, 2] = BALL_RADIUS
    states[:, 3:5] = random.uniform(-8, 8, (200, 2))
    states[:, 5] = -random.uniform(0.5, 6, 200)
    states[:, 6:] = random.uniform(-300, 300, (200, 3))
    return states


def bounced(states, physics=PHYSICS):
    after = states.copy()
    for state in after:
        bounce(state, physics)
    return after


def slope(state, physics=PHYSICS):
    result = np.empty(9)
    derivative(np.array(state, dtype=float), physics, result)
    return result


def with_(**constants):
    return PHYSICS._replace(**constants)


def test_without_hidden_causes_they_are_the_printed_laws():
    reference, states = Reference(cd=0.54), incoming()
    expected = np.array([reference.bounce(state) for state in states])
    assert bounced(states) == pytest.approx(expected, abs=1e-11)
    for state in states[:20]:
        assert slope(state) == pytest.approx(reference.derivative(0.0, state), abs=1e-11)


@pytest.mark.parametrize(
    "constants",
    [
        {"slip_dependent_friction_c": 0.01},
        {"slip_dependent_friction_c": -0.01},
        {"tangential_elasticity_et": 0.5},
        {"speed_dependent_restitution_c": 0.02},
        {"spin_dependent_restitution_c": 0.002},
        {"table_tilt_x": 0.02, "table_tilt_y": -0.03},
    ],
)
def test_bounces_keep_the_angular_momentum_about_the_contact_and_gain_no_energy(constants):
    physics = with_(table_bounce_restitution=0.85, **constants)
    before = incoming()
    normal = np.array([np.sin(physics.table_tilt_x), np.sin(physics.table_tilt_y), 1.0])
    normal /= np.linalg.norm(normal)

    after = bounced(before, physics)

    change = after - before
    twist = np.cross(BALL_RADIUS * normal, change[:, 3:6]) + 2 / 3 * BALL_RADIUS**2 * change[:, 6:]
    assert np.abs(twist).max() < 1e-11
    assert (energy(after) <= energy(before)).all()


def test_friction_acts_against_the_slip_of_each_moment():
    """The impulse is the integral of mu over the contact, here by fine Euler steps."""
    physics = with_(slip_dependent_friction_c=0.02)
    push = 1.93 * 2.0
    slip, steps = 6.0, 200_000
    for _ in range(steps):
        mu = 0.25 + 0.02 * 10.9 * (np.exp(-1.0) - np.exp(-slip / 4.0))
        slip -= 2.5 * mu * push / steps

    after = bounced(np.array([[0, 0, BALL_RADIUS, 6.0, 0, -2.0, 0, 0, 0]]), physics)[0]

    assert after[3] - BALL_RADIUS * after[7] == pytest.approx(slip, abs=1e-4)


def test_an_elastic_table_returns_slip_and_restitution_follows_its_power_law():
    gripping = np.array([[0, 0, BALL_RADIUS, 0.2, 0, -4.0, 0, 0, 0]])
    after = bounced(gripping, with_(tangential_elasticity_et=0.4))[0]
    assert after[3] - BALL_RADIUS * after[7] == pytest.approx(-0.4 * 0.2, rel=0.01)

    drops = incoming()
    drops[:, 6:] = 0.0
    e = -bounced(drops, with_(speed_dependent_restitution_c=0.02))[:, 5] / drops[:, 5]
    law = 0.93 * (-drops[:, 5] / 2.5) ** (-2.5 * 0.02 / 0.93)
    assert e == pytest.approx(np.minimum(law, 1.0))


def test_forces_of_flight_have_their_closed_forms():
    calm = [slope([0, 0, z, 0, -6, 0, 0, 0, 0])[3] for z in (0.02, 0.25)]
    windy = [slope([0, 0, z, 0, -6, 0, 0, 0, 0], with_(wind_x=1.0))[3] for z in (0.02, 0.25)]
    pushed = np.subtract(windy, calm)
    assert 0 < pushed[0] < 0.6 * pushed[1]  # the wind dies out towards the table

    loss = slope([0, 0, 1, 0, -2.0, 0, 100, 50, -20], with_(spin_decay_c=0.02))[6:]
    assert loss == pytest.approx(-0.02 * 4.0 * np.array([100, 50, -20]))

    ball = [0, 0, 1, 0, -8.0, 0, 0, 0, 0]
    aside = (slope(ball, with_(side_force_cy=0.1)) - slope(ball))[3:6]
    assert aside == pytest.approx([-0.27925 * 0.1 * 64, 0, 0], rel=1e-4)  # it does no work

    still = [0, 0, 1, 0, 0, 0, 0, 0, 0]
    pull = slope(still, with_(frame_tilt_x=0.1, frame_tilt_y=-0.05))[3:6]
    assert np.linalg.norm(pull) == pytest.approx(9.81)
    assert pull[:2] == pytest.approx([9.81 * np.sin(0.1), -9.81 * np.sin(0.05)])

    air = 1.2 * 4 / 3 * np.pi * BALL_RADIUS**3 / BALL_MASS  # displaced
    assert slope(still, with_(buoyancy_b=1.0))[5] == pytest.approx(-9.81 * (1 - air))
    assert slope(still, with_(added_mass_c=1.0))[5] == pytest.approx(-9.81 / (1 + air / 2))


def test_lift_saturates_and_breaks_down_only_where_it_should():
    slow, fast = (np.array([0, 0, 1, 0, -v, 0, 0, 0, 25 * v]) for v in (8.0, 13.0))
    spun = slow * [1, 1, 1, 1, 1, 1, 1, 1, 10]

    def lift(state, **constants):
        return slope(state, with_(**constants))[3] / slope(state)[3]

    assert lift(slow, lift_crisis_d=1.0) == pytest.approx(1.0)
    assert lift(fast, lift_crisis_d=1.0) == pytest.approx(0.0, abs=1e-12)
    assert lift(slow, lift_saturation_kappa=5.0) == pytest.approx(1.0)
    assert lift(spun, lift_saturation_kappa=5.0) < 0.4
