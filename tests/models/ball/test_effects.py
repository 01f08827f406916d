"""Every effect: its neutral value changes nothing, and its sign does what its text says."""

import numpy as np
import pytest

from models.ball.catalogue import catalogue
from models.ball.sensor import measured
from models.ball.simulator import Simulator
from models.ball.state import BALL_RADIUS
from tests.models.ball.balls import NOMINAL

TIMES = np.arange(1, 101) * 0.005
BALL = np.array([0.1, 1.2, 0.3, 0.4, -9.0, 0.5, -150.0, 40.0, 30.0])
FAST = np.array([0.0, 1.2, 0.3, 0.0, -14.0, 0.5, -350.0, 0.0, 0.0])
SLOW = np.array([0.0, 0.5, 0.3, 0.0, -3.0, 0.5, -50.0, 0.0, 0.0])
SLIDING = np.array([0.0, 1.0, 0.3, 0.0, -14.0, -5.0, 0.0, 0.0, 0.0])
LOW_SPIN = np.array([0.0, 1.0, 0.3, 0.0, -4.0, -3.0, -20.0, 0.0, 0.0])

FULL = NOMINAL.amended("net", restitution=0.2, friction=0.5).amended(
    "racket_bounce", restitution=0.878, speed_loss=0.02, kp=0.0019
)


def seen(simulator):
    """Everything a simulator can do to a ball: flight, contacts, stroke, measurement."""
    flight = simulator.fly([BALL, FAST, LOW_SPIN], TIMES)
    struck = simulator.strike([BALL], [[0.1, 0.9, 0.2]], [[0.0, 3.0, 1.0]])
    camera = measured(simulator, np.array([BALL, SLOW]), TIMES, np.random.default_rng(0))
    return [flight.states, flight.contacts.after, struck, *camera]


@pytest.mark.parametrize("name", catalogue())
def test_the_neutral_value_changes_nothing(name):
    others = {key: value for key, value in FULL.effects.items() if key != name}
    neutral = {parameter.name: parameter.neutral for parameter in catalogue()[name].parameters}
    absent, present = Simulator(others), Simulator({**others, name: neutral})
    for without, with_neutral in zip(seen(absent), seen(present), strict=True):
        np.testing.assert_array_equal(with_neutral, without)


def end(column, at=-1):
    return lambda sim, ball: sim.fly(ball, TIMES).states[0, at, column]


def end_speed(sim, ball):
    return np.linalg.norm(sim.fly(ball, TIMES[:30]).states[0, -1, 3:6])


def after_bounce(column):
    return lambda sim, ball: sim.fly(ball, TIMES).contacts.after[0, 0, column]


def bounce_height(sim, ball):
    return sim.fly(ball, TIMES).contacts.before[0, 0, 2]


def end_spin(sim, ball):
    return np.linalg.norm(sim.fly(ball, TIMES[:30]).states[0, -1, 6:9])


def from_racket(column):
    return lambda sim, ball: sim.strike(ball, [0, 1, 0], [0, 0, 0])[0, column]


def measured_position(column, at):
    def observe(sim, ball):
        return measured(sim, ball[None], TIMES, np.random.default_rng(0))[0][0, at, column]

    return observe


def measured_spin(column):
    def observe(sim, ball):
        return measured(sim, ball[None], TIMES, np.random.default_rng(0))[1][0, 0, column]

    return observe


# effect, change of its parameters, ball, observable, and whether the change raises it (+1) or
# lowers it (-1). Balls fly towards -y; x is to the right when looking along +y.
SIGNS = [
    ("gravity", {"g": 0.5}, BALL, end(2, at=20), -1),
    ("drag", {"cd": 0.05}, BALL, end_speed, -1),
    ("speed_dependent_drag", {"c": 0.05}, FAST, end_speed, -1),
    ("speed_dependent_drag", {"c": 0.05}, SLOW, end_speed, +1),
    ("spin_dependent_drag", {"c": 0.05}, BALL, end_speed, -1),
    ("linear_drag", {"k1": 0.05}, BALL, end_speed, -1),
    ("magnus", {"cm": 0.02}, BALL * [1, 1, 1, 1, 1, 1, 0, 0, 1], end(0, at=20), +1),
    ("magnus", {"cm": 0.02}, BALL * [1, 1, 1, 1, 1, 1, -1, 0, 0], end(2, at=20), -1),
    ("lift_saturation", {"kappa": 3.0}, FAST * [1, 1, 1, 1, 1, 1, -1, 1, 1], end(2, at=15), +1),
    ("lift_crisis", {"d": 1.0}, FAST * [1, 1, 1, 1, 1, 1, -1, 1, 1], end(2, at=15), +1),
    ("spin_decay", {"c": 0.01}, BALL, end_spin, -1),
    ("wind", {"x": 1.0}, BALL, end(0), +1),
    ("wind", {"y": 1.0}, BALL, end(1), +1),
    ("wind", {"z": 1.0}, BALL, end(2, at=20), +1),
    ("frame_tilt", {"x": 0.01}, BALL, end(0, at=20), +1),
    ("frame_tilt", {"y": 0.01}, BALL, end(1, at=20), +1),
    ("buoyancy", {"b": 1.0}, BALL, end(2, at=20), +1),
    ("added_mass", {"c": 1.0}, BALL, end_speed, +1),
    ("side_force", {"cy": 0.05}, BALL, end(0), -1),
    ("table_bounce", {"restitution": 0.03}, BALL, after_bounce(5), +1),
    ("table_bounce", {"friction": 0.05}, BALL, after_bounce(4), +1),
    ("speed_dependent_restitution", {"c": 0.02}, LOW_SPIN, after_bounce(5), -1),
    ("spin_dependent_restitution", {"c": 0.01}, LOW_SPIN, after_bounce(5), -1),
    (
        "slip_dependent_friction",
        {"c": 0.01},
        SLIDING,
        after_bounce(4),
        +1,
    ),
    (
        "tangential_elasticity",
        {"et": 0.2},
        SLOW * [1, 1, 1, 0.1, 0.1, 1, 1, 1, 1],
        after_bounce(6),
        +1,
    ),
    ("table_height", {"h": 0.01}, BALL, bounce_height, +1),
    ("table_tilt", {"x": 0.02}, BALL, after_bounce(3), +1),
    ("table_tilt", {"y": 0.02}, BALL, after_bounce(4), +1),
    (
        "net",
        {"restitution": 0.1},
        np.array([0, 0.3, 0.1, 0, -9, 0.5, 0, 0, 0]),
        after_bounce(4),
        +1,
    ),
    ("net", {"friction": 0.1}, np.array([0, 0.1, 0.1, 6, -1, 0.5, 0, 0, 0]), after_bounce(3), -1),
    ("racket_bounce", {"restitution": 0.05}, BALL, from_racket(4), +1),
    ("racket_bounce", {"speed_loss": 0.005}, BALL, from_racket(4), -1),
    ("racket_bounce", {"kp": 1e-4}, BALL * [1, 1, 1, 1, 1, 0, 1, 1, 1], from_racket(5), -1),
    ("position_scale", {"s": 0.01}, BALL, measured_position(1, 0), +1),
    ("clock_rate", {"d": 0.01}, BALL, measured_position(1, 20), +1),
    ("time_offset", {"tau": 0.002}, BALL, measured_position(1, 20), +1),
    ("speed_dependent_latency", {"tau": 0.0003}, BALL, measured_position(1, 20), +1),
    ("spin_gain", {"s": 0.05}, BALL, measured_spin(1), +1),
    ("spin_axis_bias", {"x": 0.02}, BALL, measured_spin(2), +1),
    ("spin_axis_bias", {"y": 0.02}, BALL, measured_spin(2), +1),
    ("spin_axis_bias", {"z": 0.02}, BALL, measured_spin(1), -1),
    ("spin_sign_flip", {"share": 1.0}, BALL, measured_spin(1), -1),
]


@pytest.mark.parametrize(("name", "change", "ball", "observe", "direction"), SIGNS)
def test_the_sign_does_what_the_text_says(name, change, ball, observe, direction):
    current = FULL.effects.get(name, {})
    changed = FULL.amended(name, **{key: current.get(key, 0.0) + by for key, by in change.items()})
    assert direction * (observe(changed, ball) - observe(FULL, ball)) > 0


def test_every_effect_has_a_sign_test():
    assert {name for name, *_ in SIGNS} == set(catalogue())


def test_friction_has_no_grip_below_zero():
    slippery = NOMINAL.amended("slip_dependent_friction", c=-0.2)
    contacts = slippery.fly(SLIDING * [1, 1, 1, 1, 0.7, 1, 1, 1, 1], TIMES).contacts
    assert contacts.count[0] > 0
    np.testing.assert_allclose(contacts.after[0, 0, 3:5], contacts.before[0, 0, 3:5])


def test_measured_positions_of_a_plain_simulator_are_the_true_ones():
    positions, spins = measured(NOMINAL, BALL[None], TIMES, np.random.default_rng(0))
    true = NOMINAL.fly(BALL, TIMES).states
    np.testing.assert_array_equal(positions, true[..., :3])
    np.testing.assert_array_equal(spins, true[..., 6:])


def test_a_tilted_table_reflects_along_its_normal():
    tilt = 0.05
    sim = NOMINAL.amended("table_tilt", y=tilt).amended("table_bounce", friction=0.0)
    contacts = sim.fly([0, 0.5, 0.3, 0, 0, -1, 0, 0, 0], TIMES).contacts
    before, after = contacts.before[0, 0], contacts.after[0, 0]
    normal = np.array([0, np.sin(tilt), 1]) / np.hypot(np.sin(tilt), 1)
    expected = before[3:6] - 1.93 * (before[3:6] @ normal) * normal
    np.testing.assert_allclose(after[3:6], expected, atol=1e-12)
    assert before[:3] @ normal == pytest.approx(BALL_RADIUS, abs=1e-9)
