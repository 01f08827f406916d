"""The environments: what gymnasium and Stable-Baselines3 ask of them, and that seeds decide."""

import gymnasium.utils.env_checker
import numpy as np
import pytest
import stable_baselines3.common.env_checker

from models.policy import ball_supply as supply
from models.policy.environment import ReturnEnv, ReturnVecEnv
from models.policy.settings import GoalSettings
from models.policy.training_balls import TrainingBalls
from tests.models.policy.simulations import SIMULATOR

GOALS = GoalSettings(
    landing_across=(-0.45, 0.45), landing_along=(0.5, 1.1), speed=(4.0, 7.0), topspin=None
)
BALLS = TrainingBalls(SIMULATOR, GOALS, (115, 120, 125))


def single():
    return ReturnEnv(SIMULATOR, BALLS, "intercept")


def many(count, seed=0):
    return ReturnVecEnv(SIMULATOR, BALLS, "intercept", count, seed)


def actions(ticks, count=1):
    return np.random.default_rng(8).uniform(-1, 1, (ticks, count, 5)).astype(np.float32)


def played(environment, ticks=60, strength=1.0):
    """Act at random; return observations, rewards and dones as bytes, and the infos."""
    seen, infos = [environment.reset().tobytes()], []
    for action in actions(ticks, environment.num_envs):
        *arrays, info = environment.step(strength * action)
        seen += [array.tobytes() for array in arrays]
        infos += [said for said in info if said]
    return seen, infos


@pytest.mark.filterwarnings("error::UserWarning:stable_baselines3")
def test_the_checkers_find_nothing_wrong():
    gymnasium.utils.env_checker.check_env(single(), skip_render_check=True)
    stable_baselines3.common.env_checker.check_env(single())


def test_one_of_many_is_like_the_single_one():
    one, among_many = single(), many(1, seed=4)
    np.testing.assert_array_equal(one.reset(seed=4)[0], among_many.reset()[0])
    for action in actions(60):
        seen, reward, done, _, info = one.step(action[0])
        others, rewards, dones, infos = among_many.step(action)
        assert (np.float32(reward), done) == (rewards[0], dones[0])
        if done:
            np.testing.assert_array_equal(seen, infos[0]["terminal_observation"])
            assert info["ball"] == infos[0]["ball"]
            seen, _ = one.reset()
        np.testing.assert_array_equal(seen, others[0])


def test_the_seed_decides_everything():
    environment = many(3, seed=7)
    first = played(environment)[0]
    environment.seed(7)

    assert played(environment)[0] == first
    assert played(many(3, seed=7))[0] == first
    assert played(many(3, seed=8))[0] != first


def test_every_ball_is_played_once_and_in_order(monkeypatch):
    monkeypatch.setattr(supply, "BATCH", 4)
    plain = TrainingBalls(SIMULATOR, GOALS, (115, 120, 125))

    _, infos = played(ReturnVecEnv(SIMULATOR, plain, "strict", 3, 0), ticks=100)

    balls = sorted(info["ball"] for info in infos)
    assert len(balls) > 8
    assert balls[:-3] == list(range(len(balls) - 3))


def test_infos_say_how_episodes_ended():
    _, infos = played(many(16), ticks=100, strength=0.3)
    hits = [info for info in infos if info["hit"]]

    assert hits
    assert {info["fault"] for info in infos} > {"missed"}
    assert all((info["fault"] == "") == info["returned"] for info in infos)
    assert all(np.isfinite(info["distance"]) == info["hit"] for info in infos)
    assert all(4.0 <= info["goal_speed"] <= 7.0 and "goal_topspin" not in info for info in infos)
    for info in hits:
        apart = np.linalg.norm(info["landing"] - info["goal_landing"])
        assert info["distance"] == pytest.approx(apart)
