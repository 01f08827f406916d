"""Policies as files and their trainings, short and small, for the tests of what uses them."""

import numpy as np

from rallygap.models.ball.simulators import shipped
from rallygap.models.policy.batch_simulation import ACTIONS
from rallygap.models.policy.observation import observation_size
from rallygap.models.policy.policy import Policy
from rallygap.pipeline.policies.storage import TrainedPolicy, save_policy
from tests.models.policy.schooling import BRIEF, GOALS, drawn_policy


def description(**changes):
    """What a small policy for landing goals, trained in simulator C, belongs to."""
    simulator = changes.get("simulator", "imperfect_c")
    plays = {"group": "small", "simulator": simulator, "effects": shipped(simulator).to_dict()}
    seen = {"horizons": (115, 120, 125), "observation": "intercept", "goals": GOALS}
    plain = {**plays, **seen, "learning": BRIEF, "seed": 3, "repeat": 0}
    return TrainedPolicy(**{**plain, **changes})


def save_drawn(folder, seed=0, **changes):
    """Save a policy of random weights as if it had been trained; return both."""
    policy, described = drawn_policy(seed), description(**changes)
    save_policy(folder / described.name, policy, described)
    return policy, described


def chaser(haste=6.0):
    """A policy that moves the racket to where the forecast ball would cross its plane."""
    weights = np.zeros((ACTIONS, observation_size(3, 2, "intercept")), dtype=np.float32)
    weights[0, -5] = weights[2, -4] = haste  # across, up
    return Policy(((weights, np.zeros(ACTIONS, dtype=np.float32)),))
