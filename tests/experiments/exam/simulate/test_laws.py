"""The independent laws: closed forms, conserved quantities and limits."""

import numpy as np
import pytest

from experiments.exam.simulate.laws import bounce, derivative, physics_of
from rallygap.models.ball.state import BALL_MASS, BALL_RADIUS
from tests.experiments.exam.example_trials import NOMINAL
from tests.models.ball.balls import energy
from tests.models.ball.reference import Physics as Reference

PHYSICS = physics_of(NOMINAL)


def incoming(count=200, seed=0):
    random = np.random.default_rng(seed)
    states = np.zeros((count, 9))
    states[:, 2] = BALL_RADIUS
    states[:, 3:5] = random.uniform(-8, 8, (count, 2))
    states[:, 5] = -random.uniform(0.5, 6, count)
    states[:, 6:] = random.uniform(-300, 300, (count, 3))
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
