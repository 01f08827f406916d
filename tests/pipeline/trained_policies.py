"""Policies as files and their trainings, short and small, for the tests of what uses them."""

from models.ball.simulators import shipped
from pipeline.policies import TrainedPolicy, save_policy
from tests.models.policy.schooling import BRIEF, GOALS, drawn_policy


def description(**changes):
    """What a small policy for landing goals, trained in simulator C, belongs to."""
    simulator = changes.get("simulator", "imperfect_c")
    plain = {
        "group": "small",
        "simulator": simulator,
        "effects": shipped(simulator).to_dict(),
        "horizons": (115, 120, 125),
        "observation": "intercept",
        "goals": GOALS,
        "learning": BRIEF,
        "seed": 3,
        "repeat": 0,
    }
    return TrainedPolicy(**{**plain, **changes})


def save_drawn(folder, seed=0, **changes):
    """Save a policy of random weights as if it had been trained; return both."""
    policy, described = drawn_policy(seed), description(**changes)
    save_policy(folder / described.name, policy, described)
    return policy, described
