"""The training environment: what seeds decide, how episodes ended, and the warm-up's motion."""

import numpy as np
import pytest

from rallygap.models.policy import environment as environments
from rallygap.models.policy.environment import ReturnVecEnv
from rallygap.models.policy.settings import GoalSettings
from rallygap.models.policy.task import Task
from tests.models.policy.simulations import SIMULATOR

GOALS = GoalSettings(
    landing_across=(-0.45, 0.45), landing_along=(0.5, 1.1), speed=(4.0, 7.0), topspin=None
)
TASK = Task(SIMULATOR, (115, 120, 125), GOALS, "intercept")


def many(count, seed=0):
    return ReturnVecEnv(TASK, count, seed)


def played(environment, ticks=40, strength=1.0):
    """Act at random; return observations, rewards and dones as bytes, and the infos."""
    seen, infos = [environment.reset().tobytes()], []
    random = np.random.default_rng(8)
    for action in random.uniform(-1, 1, (ticks, environment.num_envs, 5)).astype(np.float32):
        *arrays, info = environment.step(strength * action)
        seen += [array.tobytes() for array in arrays]
        infos += [message for message in info if message]
    return seen, infos


def test_the_seed_decides_everything():
    environment = many(3, seed=7)
    first = played(environment)[0]
    environment.seed(7)

    assert played(environment)[0] == first
    assert played(many(3, seed=7))[0] == first
    assert played(many(3, seed=8))[0] != first


def test_every_ball_is_played_once_and_in_order(monkeypatch):
    monkeypatch.setattr(environments, "BATCH", 4)
    balls = sorted(info["ball"] for info in played(many(3), ticks=80)[1])
    assert len(balls) > 6
    assert balls[:-3] == list(range(len(balls) - 3))


def test_infos_say_how_episodes_ended():
    _, infos = played(many(16), ticks=60, strength=0.3)
    hits = [info for info in infos if info["hit"]]

    assert hits
    assert {info["fault"] for info in infos} > {"missed"}
    assert all((info["fault"] == "") == info["returned"] for info in infos)
    assert all(np.isfinite(info["distance"]) == info["hit"] for info in infos)
    assert all(4.0 <= info["goal_speed"] <= 7.0 and "goal_topspin" not in info for info in infos)
    for info in hits:
        apart = np.linalg.norm(info["landing"] - info["goal_landing"])
        assert info["distance"] == pytest.approx(apart)


def test_following_hits_far_more_balls_than_acting_at_random():
    environment = many(16, seed=3)
    random = np.random.default_rng(2)
    choices = {
        "follow": lambda: environment.following_actions(random),
        "random": lambda: random.uniform(-1.0, 1.0, (16, 5)),
    }
    rates = {}
    for name, act in choices.items():
        environment.reset()
        infos = [one for _ in range(80) for one in environment.step(act())[3] if one]
        rates[name] = np.mean([one["hit"] for one in infos])
    assert rates["random"] < 0.15
    assert rates["follow"] > 0.4
