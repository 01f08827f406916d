"""Flights against closed forms, an independent integrator, and symmetries."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from rallygap.models.ball.flight import flight_environment, step
from rallygap.models.ball.state import BALL_RADIUS, TABLE_HALF_LENGTH, TABLE_HALF_WIDTH
from tests.models.ball.balls import NOMINAL, energy, served_balls, simulator
from tests.models.ball.reference import Physics

TIMES = np.arange(1, 121) * 0.005
THROWN = np.array([0.1, 1.2, 0.6, 0.5, -9.0, 1.5, -120.0, 40.0, 30.0])


@pytest.mark.parametrize("along", [(0.0, -9.0, 1.5), (14.0, 14.0, 4.0)])
def test_the_step_converges_with_order_four(along):
    p = NOMINAL.vector
    start = (0.0, 0.0, 5.0, *along, -300.0, 200.0, 100.0)

    def end(steps):
        state = start
        for _ in range(steps):
            state = step(state, 0.32 / steps, p, flight_environment(p))
        return np.array(state)

    errors = [np.abs(end(n) - end(1024)).max() for n in (8, 16, 32)]
    orders = np.log2(np.array(errors[:-1]) / errors[1:])
    np.testing.assert_allclose(orders, 4.0, atol=0.25)


def test_times_before_the_state_fly_backwards():
    there = NOMINAL.fly(THROWN, [0.05, 0.1]).states[0]
    back = NOMINAL.fly(there[1], [-0.1, -0.05, 0.0]).states[0]
    np.testing.assert_allclose(back[0], THROWN, atol=1e-8)
    np.testing.assert_allclose(back[1], there[0], atol=1e-8)
    np.testing.assert_array_equal(back[2], there[1])


def over_the_table(states):
    """Number of leading states whose ball is clear of the table's edges."""
    x, y = np.abs(states[:, 0]), np.abs(states[:, 1])
    out = (x > TABLE_HALF_WIDTH - 0.05) | (y > TABLE_HALF_LENGTH - 0.05)
    return int(np.argmax(out)) if out.any() else len(states)


def drawn_balls(count, fastest, most_spin):
    generator = np.random.default_rng(7)
    for _ in range(count):
        pitch = generator.uniform(-0.5, 0.3)
        spin = generator.normal(size=3)
        spin *= generator.uniform(0, most_spin) / np.linalg.norm(spin)
        direction = [generator.uniform(-0.1, 0.1), -np.cos(pitch), np.sin(pitch)]
        velocity = generator.uniform(4, fastest) * np.array(direction) / np.linalg.norm(direction)
        position = [generator.uniform(-0.3, 0.3), 1.3, generator.uniform(0.1, 0.5)]
        yield np.concatenate([position, velocity, spin])


@pytest.mark.parametrize(("fastest", "spin", "bound"), [(20, 600, 1e-8), (35, 1000, 1e-7)])
def test_agrees_with_an_independent_integrator(fastest, spin, bound):
    effects = {"wind": {"x": 0.3, "y": -0.2, "z": 0.1}, "spin_decay": {"c": 0.004}}
    sim = simulator(**NOMINAL.to_dict(), **effects, lift_saturation={"kappa": 5.0})
    reference = Physics(
        wind=(0.3, -0.2, 0.1),
        spin_decay=0.004,
        cm=lambda _, ratio: 0.069 * (1 + 5.0 / 2) / (1 + 5.0 * ratio),
    )
    bounces = 0
    for ball in drawn_balls(25, fastest, spin):
        expected, times = reference.fly(ball, TIMES)
        flight = sim.fly(ball, TIMES)
        seen = over_the_table(expected)
        assert np.abs(flight.states[0, :seen, :3] - expected[:seen, :3]).max(initial=0) < bound
        for k, time in enumerate(t for t in times if seen and t < TIMES[seen - 1]):
            assert flight.contacts.time[0, k] == pytest.approx(time, abs=1e-9)
            bounces += 1
    assert bounces > 12


def test_bounces_in_a_vacuum_come_when_they_must():
    g, e, drop = 9.81, 0.9, 0.3
    sim = simulator(gravity={"g": g}, table_bounce={"restitution": e, "friction": 0.2})
    contacts = sim.fly([0, 0.5, BALL_RADIUS + drop, 0, 0, 0, 0, 0, 0], np.arange(1, 61) * 0.05)
    first = np.sqrt(2 * drop / g)
    expected = first + 2 * first * np.cumsum(np.concatenate([[0], e ** np.arange(1, 6)]))
    np.testing.assert_allclose(contacts.contacts.time[0, :6], expected, atol=1e-12)


def test_a_dead_ball_comes_to_rest_on_the_table_and_one_that_rolls_over_the_edge_falls():
    sim = simulator(gravity={"g": 9.81}, table_bounce={"restitution": 0.3, "friction": 0.2})
    states = sim.fly([0, 0.5, 0.2, 0.1, 0, 0, 0, 0, 0], np.arange(1, 61) * 0.05).states[0]
    np.testing.assert_allclose(states[-20:, 2], BALL_RADIUS, atol=1e-6)
    assert states[-1, 0] > states[-20, 0]
    sim = simulator(gravity={"g": 9.81}, table_bounce={"restitution": 0.0, "friction": 0.0})
    ball = [0, TABLE_HALF_LENGTH - 0.1, BALL_RADIUS, 0, 1.0, 0, 0, 0, 0]
    states = sim.fly(ball, np.arange(1, 101) * 0.01).states[0]
    np.testing.assert_allclose(states[:8, 2], BALL_RADIUS, atol=1e-6)
    assert states[-1, 2] < -1.0


@given(served_balls(35.0, 1000.0))
@settings(max_examples=60)
def test_no_ball_sinks_through_the_table_or_gains_energy(ball):
    states = np.vstack([ball, NOMINAL.fly(ball, np.arange(1, 601) * 0.001).states[0]])
    inside = np.abs(states[:, :2]) < [TABLE_HALF_WIDTH, TABLE_HALF_LENGTH]
    on_table = np.logical_and.accumulate(inside.all(axis=1))
    assert (states[on_table, 2] >= BALL_RADIUS - 1e-9).all()
    total = energy(states, g=9.81)
    assert (np.diff(total) <= 1e-9 * total[0]).all()


def mirrored(state):
    """Left and right exchanged; spin is an axial vector."""
    return np.asarray(state) * np.array([-1, 1, 1, -1, 1, 1, 1, -1, -1])


def turned(state):
    """Seen from the other end of the table."""
    return np.asarray(state) * np.array([-1, -1, 1] * 3)


@pytest.mark.parametrize("image", [mirrored, turned])
@given(served_balls(35.0, 1000.0))
@settings(max_examples=40)
def test_the_image_of_a_shot_flies_the_image_of_its_path(image, ball):
    flown, seen = NOMINAL.fly(ball, TIMES).states, NOMINAL.fly(image(ball), TIMES).states
    np.testing.assert_allclose(seen, image(flown), atol=1e-9)


@given(served_balls(), st.lists(st.floats(0.001, 0.6), min_size=1, max_size=8))
@settings(max_examples=40)
def test_states_hardly_depend_on_the_times_asked_for(ball, times):
    asked = np.sort(np.array([*times, 0.6]))
    np.testing.assert_allclose(
        NOMINAL.fly(ball, asked).states[0, -1, :3], NOMINAL.fly(ball, TIMES).states[0, -1, :3],
        atol=2e-6,
    )  # fmt: skip


def test_a_batch_flies_as_its_balls_alone():
    balls = np.array(list(drawn_balls(20, 20, 600)))
    together = NOMINAL.fly(balls, TIMES).states
    alone = np.concatenate([NOMINAL.fly(ball, TIMES).states for ball in balls])
    np.testing.assert_array_equal(together, alone)


@pytest.mark.parametrize(
    ("states", "times"),
    [
        (np.zeros((2, 8)), [0.1]),
        (np.zeros((2, 9)), [0.2, 0.1]),
        (np.zeros((2, 9)), np.zeros((3, 1))),
        (np.full((1, 9), np.nan), [0.1]),
        (np.zeros((1, 9)), [np.inf]),
    ],
)
def test_shapes_and_times_that_do_not_fit_are_refused(states, times):
    with pytest.raises(ValueError, match=r"shape|fall|rows of times|finite"):
        NOMINAL.fly(states, times)
