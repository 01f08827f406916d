"""IncomingBalls balls for the policy's tests."""

from functools import cache

import numpy as np

from rallygap.models.ball.simulator import Simulator
from rallygap.models.ball.simulators import shipped
from rallygap.models.policy.incoming_balls import fly_incoming
from rallygap.models.policy.launches import draw_launches

TRUTH, WRONG = shipped("ground_truth"), shipped("imperfect_c")
VACUUM = Simulator.from_dict({"gravity": {"g": 9.81}})  # and no table
HORIZONS = (115, 120, 170)
# A parabola of 1.7 s that passes far above everything.
THROWN = np.array([[0.1, 1.5, 0.3, 0.2, -2.0, 8.0, 10.0, 20.0, 30.0]])


@cache
def struck(count=40, seed=0):
    """Launches, paths and playable times of balls that the robot has a chance to play."""
    launches = draw_launches(TRUTH, count, np.random.default_rng(seed))
    return launches, *fly_incoming(TRUTH, launches)


def parabola(times):
    """States of the thrown ball at any times (s), by hand."""
    times = np.asarray(times)[..., None]
    position = THROWN[0, :3] + THROWN[0, 3:6] * times - [0, 0, 4.905] * times**2
    velocity = THROWN[0, 3:6] - [0, 0, 9.81] * times
    return np.concatenate([position, velocity, 0 * times + THROWN[0, 6:]], axis=-1)
