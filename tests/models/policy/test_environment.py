"""The training environment: how episodes ended, and the warm-up's motion."""

from dataclasses import replace

import numpy as np
import pytest

from rallygap.models.policy import environment as environments
from rallygap.models.policy.environment import ReturnVecEnv
from tests.models.policy.schooling import GOALS, TASK

FAST = replace(TASK, goals=GOALS.model_copy(update={"speed": (4.0, 7.0)}))


def played(environment, actions):
    """Return the infos of all episodes that end."""
    environment.reset()
    return [info for action in actions for info in environment.step(action)[3] if info]


def at_random(ticks, count, strength=1.0):
    return np.random.default_rng(8).uniform(-strength, strength, (ticks, count, 5))


def test_every_ball_is_played_once_and_in_order(monkeypatch):
    monkeypatch.setattr(environments, "BATCH", 4)
    balls = sorted(info["ball"] for info in played(ReturnVecEnv(TASK, 3, seed=0), at_random(80, 3)))
    assert len(balls) > 6
    assert balls[:-3] == list(range(len(balls) - 3))


def test_infos_say_how_episodes_ended():
    infos = played(ReturnVecEnv(FAST, 16, seed=0), at_random(60, 16, strength=0.3))
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
    environment = ReturnVecEnv(TASK, 16, seed=3)
    random = np.random.default_rng(2)
    following = (environment.following_actions(random) for _ in range(80))
    followed, by_chance = (
        np.mean([info["hit"] for info in played(environment, actions)])
        for actions in (following, at_random(80, 16))
    )
    assert by_chance < 0.15
    assert followed > 0.4
