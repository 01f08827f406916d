"""A short training and untrained policies, for the tests of what trains and plays."""

from itertools import pairwise

import numpy as np

from rallygap.models.policy.batch_simulation import ACTIONS
from rallygap.models.policy.observation import observation_size
from rallygap.models.policy.policy import Policy
from rallygap.models.policy.settings import GoalSettings, LearningSettings
from rallygap.models.policy.task import Task
from tests.models.policy.simulations import SIMULATOR

GOALS = GoalSettings(landing_across=(-0.4, 0.4), landing_along=(0.5, 1.1), speed=None, topspin=None)
TASK = Task(SIMULATOR, (115, 120, 125), GOALS, "intercept")
BRIEF = LearningSettings(
    iterations=3, steps_per_iteration=48, environments=4, gradient_steps=2, warm_up=16, batch=8,
    width=8, learning_rate=0.01, final_learning_rate=0.0001, discount=0.98,
    target_step=0.005, entropy=0.1,
)  # fmt: skip


def drawn_policy(seed=0, width=8, kind="intercept", goals=2):
    """Return a policy of random weights that moves the arm about."""
    random = np.random.default_rng(seed)
    sizes = [observation_size(3, goals, kind), width, ACTIONS]
    drawn = [
        (random.normal(0, 0.3, (after, before)), random.normal(0, 0.3, after))
        for before, after in pairwise(sizes)
    ]
    return Policy(tuple((w.astype(np.float32), b.astype(np.float32)) for w, b in drawn))


def resting_policy(kind="strict", goals=2):
    """Return a policy that lets the arm wait in neutral."""
    shape = (ACTIONS, observation_size(3, goals, kind))
    return Policy(((np.zeros(shape, np.float32), np.zeros(ACTIONS, np.float32)),))


def same(policy, other):
    """Return whether two policies have the same weights, to the last bit."""
    one, two = policy.to_arrays(), other.to_arrays()
    return one.keys() == two.keys() and all(np.array_equal(one[name], two[name]) for name in one)
