"""Aim: the ball reaches the place in the time, or later where the net asks for it."""

import numpy as np
import pytest

from rallygap.models.arena.strokes import aim_launches
from tests.models.arena.sessions import TRUTH

AIR = TRUTH.simulator.without_surfaces()


def aim(height=0.3, seconds=0.5, spin=(-100.0, 0.0, 50.0), clearance=0.02):
    return aim_launches(
        TRUTH.simulator,
        np.array([[0.2, -1.4, height]]),
        np.array([spin]),
        np.array([[-0.3, 0.9]]),
        np.array([seconds]),
        np.array([clearance]),
    )


@pytest.mark.parametrize("spin", [(0, 0, 0), (-400, 100, 200), (200, 0, 0)])
def test_it_reaches_its_target_in_time(spin):
    end = AIR.fly(aim(spin=spin), [0.5]).states[0, 0, :3]

    assert end == pytest.approx([-0.3, 0.9, 0.02], abs=0.01)


def test_low_balls_cannot_be_smashed_and_clear_the_net_by_what_was_asked():
    low, high = (np.linalg.norm(aim(height, seconds=0.2)[0, 3:6]) for height in (0.1, 0.9))
    assert high > 10
    assert low < 0.8 * high
    path = AIR.fly(aim(height=0.1, seconds=0.25, clearance=0.1), np.linspace(0, 1, 1000)).states[0]
    at_net = path[np.abs(path[:, 1]).argmin(), 2]
    assert at_net > 0.1525 + 0.02 + 0.1 - 0.01
