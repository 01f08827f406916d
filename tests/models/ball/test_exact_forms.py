"""Every effect against its equation, written again from scratch.

Nothing here is shared with ``models/ball`` but the simulator under test; flights are integrated
by scipy to 1e-12, contacts computed from the impulses on a thin shell.
"""

import numpy as np
import pytest
from hypothesis import assume, given, settings

from rallygap.models.ball.catalogue import catalogue
from rallygap.models.ball.contact_laws import NET
from rallygap.models.ball.sensor import measured
from rallygap.models.ball.simulator import Simulator
from tests.models.ball.balls import NET_PLAY, NOMINAL, RACKET, simulator, vectors
from tests.models.ball.reference import DRAG, LIFT, MASS, RADIUS, Physics

G, CD, CM = 9.81, 0.55, 0.069
RESTITUTION, FRICTION = 0.93, 0.25
UP = np.array([0.0, 0.0, 1.0])
TIMES = np.arange(1, 41) * 0.005


def crisis(d):
    def lift(speed, ratio):
        onset = 1 / (1 + np.exp(-(speed - 11) / 0.4))
        return CM * (1 - d * np.exp(-(((ratio - 0.5) / 0.15) ** 2) / 2) * onset)

    return lift


def leaning(x, y):
    return np.array([x, y, -np.sqrt(1 - x**2 - y**2)])


def right_of(u):
    side = np.cross(u, UP)
    return side / np.linalg.norm(side)


FLIGHTS = [
    ("gravity", {"g": 9.5}, {"gravity": 9.5 * -UP}),
    ("drag", {"cd": 0.41}, {"cd": 0.41}),
    ("speed_dependent_drag", {"c": -0.06}, {"cd": lambda v, _: CD - 0.06 * (v - 8) / 5}),
    ("spin_dependent_drag", {"c": 0.1}, {"cd": lambda _, s: CD + 0.1 * (s - 0.5)}),
    ("linear_drag", {"k1": 0.3}, {"other": lambda u: -0.3 * u}),
    ("magnus", {"cm": 0.12}, {"cm": 0.12}),
    ("lift_saturation", {"kappa": 5.0}, {"cm": lambda _, s: CM * (1 + 5.0 / 2) / (1 + 5.0 * s)}),
    ("lift_crisis", {"d": 1.5}, {"cm": crisis(1.5)}),
    ("spin_decay", {"c": 0.02}, {"spin_decay": 0.02}),
    ("wind", {"x": 0.5, "y": -1.0, "z": 0.3}, {"wind": (0.5, -1.0, 0.3)}),
    ("frame_tilt", {"x": 0.02, "y": -0.03}, {"gravity": G * leaning(np.sin(0.02), np.sin(-0.03))}),
    ("buoyancy", {"b": 1.0}, {"gravity": -G * (1 - LIFT) * UP}),
    ("added_mass", {"c": 1.0}, {"mass": 1 + LIFT / 2}),
    ("side_force", {"cy": 0.05}, {"other": lambda u: DRAG * 0.05 * (u @ u) * right_of(u)}),
]


@pytest.mark.parametrize(("name", "parameters", "law"), FLIGHTS, ids=[f[0] for f in FLIGHTS])
def test_flight_follows_the_equation(name, parameters, law):
    free = simulator(gravity={"g": G}, drag={"cd": CD}, magnus={"cm": CM})
    for heading, speed, spin in (
        ((0.0, -1.0, 0.05), 20.0, 600.0),
        ((0.6, 0.5, 0.6), 11.5, 290.0),
        ((-1.0, 0.1, -0.2), 4.0, 100.0),
    ):
        velocity = speed * np.array(heading) / np.linalg.norm(heading)
        ball = np.concatenate([[0, 0, 2], velocity, spin * np.array([-0.6, 0.48, 0.64])])
        states = free.amended(name, **parameters).fly(ball, TIMES).states[0]
        expected, _ = Physics(**law).fly(ball, TIMES)
        np.testing.assert_allclose(states[:, :3], expected[:, :3], atol=1e-8)
        np.testing.assert_allclose(states[:, 6:], expected[:, 6:], atol=1e-6)


def impulse(state, normal, restitution, share, racket=(0, 0, 0)):
    """State after a contact that takes a ``share`` (a function of slip) of the contact's slip."""
    v, w = state[3:6] - racket, state[6:]
    arm = -RADIUS * normal
    normal_speed = -(v @ normal)
    slip = v + normal_speed * normal + np.cross(w, arm)
    tangential = -MASS * share(np.linalg.norm(slip)) * slip
    total = MASS * (1 + restitution) * normal_speed * normal + tangential
    spin = w + np.cross(arm, tangential) / (2 / 3 * MASS * RADIUS**2)
    return np.concatenate([state[:3], state[3:6] + total / MASS, spin])


def bounced(state, *, normal=UP, e=RESTITUTION, mu=FRICTION, most=0.4):
    """After the table; ``e`` may be a function of normal speed and spin, ``mu`` of slip."""
    normal_speed = -(state[3:6] @ normal)
    spin = RADIUS * np.linalg.norm(np.cross(state[6:], normal))
    restitution = e(normal_speed, spin) if callable(e) else e

    def share(slip):
        grip = mu(slip) if callable(mu) else mu
        return min(grip * (1 + restitution) * normal_speed / slip, most)

    return impulse(state, normal, restitution, share)


TILTED = np.array([np.sin(0.03), np.sin(-0.05), 1.0])
TABLES = [
    ("table_bounce", {"restitution": 0.87, "friction": 0.16}, {"e": 0.87, "mu": 0.16}),
    ("speed_dependent_restitution", {"c": 0.02}, {"e": lambda n, _: 0.93 - 0.02 * (n - 2.5)}),
    ("spin_dependent_restitution", {"c": 0.01}, {"e": lambda _, spin: 0.93 + 0.01 * (spin - 3)}),
    ("slip_dependent_friction", {"c": 0.02}, {"mu": lambda slip: FRICTION + 0.02 * (slip - 4)}),
    ("tangential_elasticity", {"et": 0.3}, {"most": 0.4 * 1.3}),
    ("table_tilt", {"x": 0.03, "y": -0.05}, {"normal": TILTED / np.linalg.norm(TILTED)}),
    ("table_height", {"h": 0.022}, {}),
]
SLIDING = [0.1, 0.9, 0.3, 1.0, -14.0, -3.0, 80.0, -60.0, 50.0]
ROLLING = [0.1, 0.6, 0.3, 0.3, -2.0, -3.0, 60.0, 40.0, -90.0]


@pytest.mark.parametrize("ball", [SLIDING, ROLLING], ids=["sliding", "rolling"])
@pytest.mark.parametrize(("name", "parameters", "law"), TABLES, ids=[t[0] for t in TABLES])
def test_bounces_follow_the_equation(name, parameters, law, ball):
    contacts = NOMINAL.amended(name, **parameters).fly(ball, TIMES).contacts
    before, after = contacts.before[0, 0], contacts.after[0, 0]
    np.testing.assert_allclose(after, bounced(before, **law), rtol=1e-11, atol=1e-11)
    height = parameters.get("h", 0.0)
    assert (before[:3] - height * UP) @ law.get("normal", UP) == pytest.approx(RADIUS, abs=1e-12)


@given(vectors(15.0), vectors(300.0), vectors(10.0), vectors(1.0))
@settings(max_examples=60)
def test_a_racket_follows_the_equation(velocity, spin, racket, normal):
    assume(np.linalg.norm(normal) > 0.1)
    n = normal / np.linalg.norm(normal)
    approach = (velocity - racket) @ n
    assume(approach < -0.1)
    before = np.concatenate([[0, -1.5, 0.2], velocity, spin])
    expected = impulse(before, n, 0.878 + 0.02 * approach, lambda _: 1.9 / 2.7, racket)
    struck = simulator(racket_bounce=RACKET).strike(before, normal, racket)[0]
    np.testing.assert_allclose(struck, expected, atol=1e-10)


@pytest.mark.parametrize(
    "velocity", [(6.0, -1.0, 0.5), (0.3, -9.0, 0.5)], ids=["sliding", "rolling"]
)
def test_the_net_follows_the_equation_of_the_table(velocity):
    ball = [0.1, 0.1, 0.08, *velocity, 80.0, -60.0, 50.0]
    contacts = NOMINAL.amended("net", restitution=0.2, friction=0.15).fly(ball, TIMES).contacts
    assert contacts.surface[0, 0] == NET
    before, after = contacts.before[0, 0], contacts.after[0, 0]
    expected = bounced(before, normal=np.array([0, 1, 0]), e=0.2, mu=0.15)
    np.testing.assert_allclose(after, expected, rtol=1e-11, atol=1e-11)


THROWN, TURNING = np.array([0.2, 1.0, 0.4, 0.5, -6.0, 2.0]), np.array([-150.0, 40.0, 30.0])
BIAS = np.array([0.3, -0.2, 0.5])
BIASED = dict(zip("xyz", BIAS, strict=True))


def parabola(times):
    t = np.asarray(times)[:, None]
    return THROWN[:3] + THROWN[3:] * t - G / 2 * t**2 * UP


def rotated(vector, about):
    """Rodrigues' formula."""
    angle = np.linalg.norm(about)
    axis = about / angle
    flat = np.cos(angle) * vector + np.sin(angle) * np.cross(axis, vector)
    return flat + (1 - np.cos(angle)) * (axis @ vector) * axis


SENSORS = [
    ("position_scale", {"s": 0.02}, 1.02 * parabola(TIMES), TURNING),
    (
        "camera_distortion",
        {"amplitude": 0.01, "length": 0.5, "nodes": [[0.0, 0.0, 1.0, 1.0, -2.0, 0.5]]},
        parabola(TIMES)
        + 0.01
        * np.exp(-2.0 * ((parabola(TIMES) - [0.0, 0.0, 1.0]) ** 2).sum(axis=1))[:, None]
        * [1.0, -2.0, 0.5],
        TURNING,
    ),
    ("clock_rate", {"d": 0.1}, parabola(TIMES / 1.1), TURNING),
    ("time_offset", {"tau": 0.004}, parabola(TIMES - 0.004), TURNING),
    ("spin_gain", {"s": -0.1}, parabola(TIMES), 0.9 * TURNING),
    ("spin_axis_bias", BIASED, parabola(TIMES), rotated(TURNING, BIAS)),
    ("spin_sign_flip", {"share": 1.0}, parabola(TIMES), -TURNING),
    (
        "speed_dependent_latency",
        {"tau": 0.0005},
        parabola(TIMES - 0.0005 * np.linalg.norm(THROWN[3:] - G * TIMES[:, None] * UP, axis=1)),
        TURNING,
    ),
]


@pytest.mark.parametrize(
    ("name", "parameters", "positions", "spin"), SENSORS, ids=[one[0] for one in SENSORS]
)
def test_what_a_sensor_sees_follows_the_equation(name, parameters, positions, spin):
    ball = np.concatenate([THROWN, TURNING])[None]
    vacuum = simulator(gravity={"g": G}).amended(name, **parameters)
    seen, labels = measured(vacuum, ball, TIMES, np.random.default_rng(0))
    np.testing.assert_allclose(seen[0], positions, atol=1e-12)
    np.testing.assert_allclose(labels[0], np.tile(spin, (len(TIMES), 1)), atol=1e-10)


BALL = np.array([0.1, 1.2, 0.3, 0.4, -9.0, 0.5, -150.0, 40.0, 30.0])
BALLS = np.array(
    [BALL, [0.0, 1.2, 0.3, 0.0, -14.0, 0.5, -350.0, 0.0, 0.0], [0, 1, 0.3, 0, -4, -3, -20, 0, 0]]
)
FULL = NET_PLAY.amended("racket_bounce", **RACKET)


def seen(simulator):
    """Everything a simulator can do to a ball: flight, contacts, stroke, measurement."""
    times = np.arange(1, 101) * 0.005
    flight = simulator.fly(BALLS, times)
    struck = simulator.strike([BALL], [[0.1, 0.9, 0.2]], [[0.0, 3.0, 1.0]])
    camera = measured(simulator, BALLS, times, np.random.default_rng(0))
    return [flight.states, flight.contacts.after, struck, *camera]


@pytest.mark.parametrize("name", catalogue())
def test_the_neutral_value_changes_nothing(name):
    others = {key: value for key, value in FULL.effects.items() if key != name}
    neutral = {parameter.name: parameter.neutral for parameter in catalogue()[name].parameters}
    if catalogue()[name].table:
        neutral["nodes"] = [[0.0, 0.0, 1.0, 1.0, 1.0, 1.0]]
    absent, present = Simulator(others), Simulator({**others, name: neutral})
    for without, with_neutral in zip(seen(absent), seen(present), strict=True):
        np.testing.assert_array_equal(with_neutral, without)


def test_every_effect_is_compared_with_its_equation():
    compared = {name for name, *_ in (*FLIGHTS, *TABLES, *SENSORS)} | {"racket_bounce", "net"}
    assert compared == set(catalogue())
