"""Variation: the arcs of balls."""

import numpy as np
import pytest

from models.ball.state import POSITION
from models.gap.fit.measurement import KINK, Schedule, predict_measurements
from models.gap.locate.sensitivity import arcs
from tests.models.gap.hidden import NOMINAL, launches

TIMES = np.arange(0.0, 0.7, 0.005)
COUNT = 5
STATES = launches(COUNT, np.random.default_rng(1))
PLACES = np.tile(np.arange(len(TIMES)), (COUNT, 1))
MOMENTS = Schedule(np.tile(TIMES, (COUNT, 1)), PLACES, PLACES)


def test_arcs_share_the_moments_out():
    found = arcs(NOMINAL, STATES, MOMENTS.times)
    times_seen = np.zeros(MOMENTS.times.shape)
    for arc in found:
        times_seen[arc.rows] += arc.inside
    away = predict_measurements(NOMINAL, MOMENTS, STATES).is_smooth(MOMENTS.times, 2 * KINK)
    assert np.all(times_seen[away] == 1)
    assert np.all(times_seen <= 1)
    path = NOMINAL.fly(STATES, TIMES).states
    first = found[0]
    assert first.states[first.inside][:, POSITION] == pytest.approx(path[first.inside][:, POSITION])
