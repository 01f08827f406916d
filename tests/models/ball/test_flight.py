"""Flight against closed forms."""

import numpy as np
import pytest

from rallygap.models.ball.flight import flight_environment, step
from tests.models.ball.balls import NOMINAL, simulator

TIMES = np.arange(1, 61) * 0.005
BALL = np.array([0.1, 1.2, 0.6, 0.5, -9.0, 1.5, -120.0, 40.0, 30.0])


def test_a_vacuum_gives_the_parabola():
    flown = simulator(gravity={"g": 9.81}).fly(BALL, TIMES).states[0]
    t = TIMES[:, None]
    expected = BALL[:3] + BALL[3:6] * t + np.array([0, 0, -9.81]) * t**2 / 2
    np.testing.assert_allclose(flown[:, :3], expected, atol=1e-13)
    np.testing.assert_array_equal(flown[:, 6:], np.tile(BALL[6:], (60, 1)))


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
    there = NOMINAL.fly(BALL, [0.05, 0.1]).states[0]
    back = NOMINAL.fly(there[1], [-0.1, -0.05, 0.0]).states[0]
    np.testing.assert_allclose(back[0], BALL, atol=1e-8)
    np.testing.assert_allclose(back[1], there[0], atol=1e-8)
    np.testing.assert_array_equal(back[2], there[1])
