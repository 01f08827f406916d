"""The motion of the warm-up: rackets go where the balls go, and hit them."""

import numpy as np

from rallygap.models.policy.batch_simulation import following_actions
from rallygap.models.policy.environment import ReturnVecEnv
from rallygap.models.robot.constants import NEUTRAL
from rallygap.models.robot.kinematics import racket
from tests.models.policy.schooling import TASK

ARMS, AT_REST = np.tile(NEUTRAL, (400, 1)), np.zeros((400, 6))


def actions(across, above, ahead):
    """Actions for balls that come along y, this far from the racket."""
    rackets = racket(ARMS, AT_REST)
    balls = np.zeros((400, 9))
    balls[:, :3] = rackets.position + np.array([across, ahead, above])
    balls[:, 4] = -10.0
    return following_actions(rackets, balls, np.random.default_rng(1))


def test_rackets_move_to_the_side_and_height_of_the_ball():
    mean = actions(across=0.05, above=-0.1, ahead=0.0).mean(axis=0)
    np.testing.assert_allclose(mean[[0, 2, 3, 4]], [0.4, -0.8, 0.0, 0.0], atol=0.05)


def test_rackets_move_ahead_once_the_ball_is_near():
    assert actions(0.0, 0.0, ahead=0.5)[:, 1].min() >= 0.0
    assert abs(actions(0.0, 0.0, ahead=1.0)[:, 1].mean()) < 0.05


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
