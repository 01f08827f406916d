"""Scatter: of the size stated, along the law of the bounce, and never a gain of energy."""

import numpy as np
import pytest

from rallygap.models.arena.bounce_scatter import BounceScatter, table_normals
from rallygap.models.ball.simulator import Simulator
from rallygap.models.ball.state import BALL_RADIUS
from tests.models.arena.sessions import TRUTH, flying
from tests.models.ball.balls import energy

SCATTER = BounceScatter(restitution=0.012, friction=0.05)


def bounces(count=3000, seed=0, simulator=TRUTH.simulator, **limits):
    contacts = simulator.fly(
        flying(count, np.random.default_rng(seed), **limits), [0, 0.05]
    ).contacts
    inside = (np.abs(contacts.before[:, 0, :2]) < [0.75, 1.35]).all(axis=1)  # not on an edge
    met = (contacts.surface[:, 0] == 1) & inside
    return contacts.before[met, 0], contacts.after[met, 0]


def apply(before, after, scatter=SCATTER, simulator=TRUTH.simulator):
    return scatter.apply(simulator, before, after, np.random.default_rng(1))


def test_the_normal_rebound_deviates_by_the_stated_share():
    level = Simulator.from_dict(
        {"table_bounce": {"restitution": 0.9, "friction": 0.2}, "gravity": {"g": 9.81}}
    )
    before, after = bounces(simulator=level, fastest=10.0)

    factor = apply(before, after, simulator=level)[:, 5] / after[:, 5]

    assert factor.mean() == pytest.approx(1.0, abs=0.001)
    assert factor.std() == pytest.approx(0.012, rel=0.05)


def test_the_tangential_impulse_of_sliding_balls_deviates_by_the_stated_share():
    before, after = bounces(fastest=20.0, most_spin=50.0)
    sliding = np.linalg.norm(before[:, 3:5], axis=1) > 2 * np.abs(before[:, 5])

    spun = (apply(before, after) - before)[sliding, 6:8]
    factor = np.linalg.norm(spun, axis=1) / np.linalg.norm((after - before)[sliding, 6:8], axis=1)

    assert sliding.sum() > 300
    assert factor.mean() == pytest.approx(1.0, abs=0.01)
    assert factor.std() == pytest.approx(0.05, rel=0.15)


def test_angular_momentum_about_the_contact_point_is_kept_and_energy_never_grows():
    before, after = bounces()
    normal = table_normals(TRUTH.simulator, before[:, :3])
    scattered = apply(before, after, BounceScatter(restitution=0.2, friction=0.5))
    change = scattered - before

    twist = np.cross(BALL_RADIUS * normal, change[:, 3:6]) + 2 / 3 * BALL_RADIUS**2 * change[:, 6:]
    assert np.abs(twist).max() < 1e-9
    assert (energy(scattered) <= energy(before) * (1 + 1e-12)).all()
    assert (scattered[:, 5] > -1e-9).all()


def test_normals_point_from_the_nearest_point_of_the_table():
    flat = Simulator.from_dict({"table_height": {"h": 0.01}})
    places = np.array([[0.1, 0.2, 0.03], [0.7765, 0.0, 0.024]])

    assert table_normals(flat, places) == pytest.approx(
        np.array([[0, 0, 1], [0.7071068, 0, 0.7071068]]), abs=1e-6
    )
