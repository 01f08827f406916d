"""The motion of the warm-up: rackets go where the balls go, and hit them."""

import numpy as np

from rallygap.models.policy.environment import ReturnVecEnv
from rallygap.models.robot.constants import NEUTRAL
from tests.models.policy.schooling import TASK

ARMS, AT_REST = np.tile(NEUTRAL, (400, 1)), np.zeros((400, 6))


def test_following_hits_far_more_balls_than_acting_at_random():
    environment = ReturnVecEnv(TASK, 16, 3)
    random = np.random.default_rng(2)
    choices = {
        "follow": lambda: environment.following_actions(random),
        "random": lambda: random.uniform(-1.0, 1.0, (16, 5)),
    }
    rates = {}
    for name, act in choices.items():
        environment.reset()
        infos = [one for _ in range(150) for one in environment.step(act())[3] if one]
        rates[name] = np.mean([one["hit"] for one in infos])
    assert rates["random"] < 0.1
    assert rates["follow"] > 0.5
