"""Transitions are told under new goals, and are worth what these make of them."""

import numpy as np
import pytest
from gymnasium import spaces

from rallygap.models.policy.goal_relabelling import RelabellingReplayBuffer
from rallygap.models.policy.goals import Goals
from rallygap.models.policy.reward import goal_reward
from rallygap.models.policy.settings import RewardSettings
from tests.models.policy.schooling import GOALS

COLUMNS, WEIGHTS = slice(3, 5), RewardSettings()
LANDING, SPEED, TOPSPIN = np.array([0.1, 0.9]), 5.0, -20.0
OLD_GOAL = np.array([0.2, 0.6])


def worth(goal):
    stroke = LANDING[None], np.array([SPEED]), np.array([TOPSPIN]), np.array([True])
    return goal_reward(*stroke, Goals(goal[None]), WEIGHTS)[0]


@pytest.fixture
def replay():
    """A tick in which one arm strikes its ball, and one in which it does not."""
    seen, done = spaces.Box(-5, 5, (7,), np.float32), spaces.Box(-1, 1, (2,), np.float32)
    kept = RelabellingReplayBuffer(
        2, seen, done, n_envs=1, goals=GOALS, columns=COLUMNS, weights=WEIGHTS
    )
    struck = {"hit": True, "landing": LANDING, "speed": SPEED, "topspin": TOPSPIN, "returned": True}
    struck["goal_reward"] = worth(OLD_GOAL)
    rows = np.arange(7.0)[None] / 10
    for reward, info in ((-0.02, {}), (0.7 + worth(OLD_GOAL), struck)):
        ended = np.array([bool(info)])
        kept.add(rows, rows + 0.01, np.ones((1, 2)), np.array([reward]), ended, [info])
    np.random.seed(1)
    return kept.sample(64)


def goals_of(samples):
    scaled = samples.observations[:, COLUMNS].numpy()
    assert np.array_equal(scaled, samples.next_observations[:, COLUMNS].numpy())
    return scaled * [0.45, 0.3] + [0.0, 0.8]


def test_every_call_draws_other_goals(replay):
    across, along = goals_of(replay).T
    assert len(np.unique(across)) == 64
    assert -0.4 <= across.min() < -0.3 < 0.3 < across.max() <= 0.4
    assert 0.5 <= along.min() < 0.6 < 1.0 < along.max() <= 1.1


def test_a_stroke_is_worth_what_the_new_goal_makes_of_it_and_all_else_stays(replay):
    ended = replay.dones[:, 0].numpy() == 1
    expected = [0.7 + worth(goal) for goal in goals_of(replay)[ended]]
    assert replay.rewards[ended, 0].numpy() == pytest.approx(expected, abs=1e-5)
    assert np.ptp(expected) > 0.3
    assert ended.any() and not ended.all()
    assert (replay.rewards[~ended].numpy() == np.float32(-0.02)).all()
    kept = [0, 1, 2, 5, 6]
    assert np.allclose(replay.observations[:, kept].numpy(), np.array(kept) / 10)
    assert np.allclose(replay.next_observations[:, kept].numpy(), np.array(kept) / 10 + 0.01)
