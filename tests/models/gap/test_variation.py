"""Variation: exact accelerations, through bounces too."""

import numpy as np
import pytest

from models.ball.simulator import Simulator
from models.ball.state import POSITION, VELOCITY
from models.gap.motion import KINK, Moments, seen
from models.gap.variation import arcs, response
from tests.models.gap.hidden import NOMINAL, launches

TIMES = np.arange(0.0, 0.7, 0.005)
COUNT = 5
STATES = launches(COUNT, np.random.default_rng(1))
PLACES = np.tile(np.arange(len(TIMES)), (COUNT, 1))
MOMENTS = Moments(np.tile(TIMES, (COUNT, 1)), PLACES, PLACES)


def changed(simulator, forcing):
    found = arcs(simulator, STATES, MOMENTS.times)
    return response(found, forcing)[..., 0]


def forced(direction):
    forcing = np.zeros((COUNT, len(TIMES), 9, 1))
    forcing[..., VELOCITY, 0] = direction
    return forcing


def test_a_constant_acceleration_without_air_gives_half_its_square():
    free = Simulator.from_dict({"gravity": {"g": 9.81}})
    change = changed(free, forced([1.0, 0.0, -2.0]))
    expected = 0.5 * TIMES[:, None] ** 2 * np.array([1.0, 0.0, -2.0])
    assert change == pytest.approx(np.broadcast_to(expected, change.shape), abs=1e-5)


def test_a_change_of_gravity_through_bounces_is_that_of_exact_flights():
    h = 1e-3
    flights = [
        seen(NOMINAL.amended("gravity", g=9.81 + sign * h), MOMENTS, STATES) for sign in (1, -1)
    ]
    exact = (flights[0].positions - flights[1].positions) / (2 * h)
    change = changed(NOMINAL, forced([0.0, 0.0, -1.0]))
    assert np.isfinite(flights[0].contacts).any(axis=1).all()
    away = flights[0].smooth(MOMENTS.times, 0.006)
    assert change[away] == pytest.approx(exact[away], abs=0.01 * np.abs(exact).max())


def test_arcs_share_the_moments_out():
    found = arcs(NOMINAL, STATES, MOMENTS.times)
    times_seen = np.zeros(MOMENTS.times.shape)
    for arc in found:
        times_seen[arc.rows] += arc.inside
    away = seen(NOMINAL, MOMENTS, STATES).smooth(MOMENTS.times, 2 * KINK)
    assert np.all(times_seen[away] == 1)
    assert np.all(times_seen <= 1)
    path = NOMINAL.fly(STATES, TIMES).states
    first = found[0]
    assert first.states[first.inside][:, POSITION] == pytest.approx(path[first.inside][:, POSITION])
