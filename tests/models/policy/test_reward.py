"""Rewards, worked by hand."""

import numpy as np
import pytest

from rallygap.models.policy.goals import Goals
from rallygap.models.policy.outcome import Outcome
from rallygap.models.policy.reward import contact_reward, goal_reward
from rallygap.models.policy.settings import RewardSettings

WEIGHTS = RewardSettings()


def reward(returned=True, distance=0.0, net_height=0.3, backhand=False, weights=WEIGHTS, **goals):
    """Of a ball of 6 m/s and a topspin of 50 rad/s, under goals of speed and topspin."""
    nothing = np.full((1, 9), np.nan)
    landing = np.array([[distance, 0.0]])
    numbers = [np.array([value]) for value in (distance, net_height, 6.0, 50.0)]
    played = Outcome(np.array([returned]), np.array([""]), nothing, landing, *numbers)
    asked = Goals(np.zeros((1, 2)), **{name: np.array([goal]) for name, goal in goals.items()})
    stroke = landing, played.speed, played.topspin, played.returned
    whatever_the_goal = contact_reward(played, np.array([backhand]), weights)
    return (whatever_the_goal + goal_reward(*stroke, asked, weights))[0]


@pytest.mark.parametrize(
    ("described", "expected"),
    [
        ({}, 0.5 + 3.0 + 0.3 + 1.0),
        ({"returned": False}, 0.5 + 3.0 + 0.3),
        ({"backhand": True}, 4.8 - 0.5),
        ({"distance": 0.6}, 0.5 + 3.0 / np.e + 0.3 / 1.6 + 1.0),
        ({"net_height": 0.2025}, 4.8),
        ({"net_height": 0.1725}, 4.8 - 0.5 * 0.1),
        ({"net_height": -8.0, "returned": False}, 3.8 - 0.5),
        ({"speed": 6.0}, 4.8 + 9.0 + 12.0),
        ({"speed": 6.0, "distance": 0.4}, 0.5 + 12.0 / np.e + 0.3 / 1.4 + 1.0 + 12.0),
        ({"speed": 5.2}, 4.8 + 9.0 + 12.0 / np.e),
        ({"topspin": 110.0}, 4.8 + 9.0 + 8.0 / np.e),
        ({"topspin": 50.0, "speed": 6.0}, 4.8 + 9.0 + 20.0),
        ({"topspin": 50.0, "speed": 6.0, "returned": False}, 3.8 + 9.0),
        ({"weights": RewardSettings(landing=6.0)}, 4.8 + 3.0),
        ({"weights": RewardSettings(returned=0.0)}, 4.8 - 1.0),
    ],
)
def test_a_stroke_is_worth(described, expected):
    assert reward(**described) == pytest.approx(expected)
