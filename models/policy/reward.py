"""The reward.

A hit is rewarded more the nearer the ball comes to the goal, returned or not, so that the reward
has a gradient from the first contact on.
"""

import numpy as np

from rallygap.models.ball.state import BALL_RADIUS, NET_HEIGHT
from rallygap.models.ball.types import Bools, Floats
from rallygap.models.policy.goals import Goals
from rallygap.models.policy.outcome import Outcome
from rallygap.models.policy.settings import RewardSettings

NET_DEPTH = 0.3  # m below the clearance at which the penalty is full
NET_CLEARANCE = NET_HEIGHT + BALL_RADIUS + 0.03  # m: 3 cm between ball and net


def contact_reward(outcome: Outcome, backhand: Bools, weights: RewardSettings) -> Floats:
    """Return the (B,) parts of the rewards of hits that do not depend on the goals."""
    low = weights.net * np.clip((NET_CLEARANCE - outcome.net_height) / NET_DEPTH, 0.0, 1.0)
    return weights.contact - low - weights.backhand * backhand + weights.returned * outcome.returned


def goal_reward(
    landing: Floats,
    speed: Floats,
    topspin: Floats,
    returned: Bools,
    goals: Goals,
    weights: RewardSettings,
) -> Floats:
    """Return the (B,) parts of the rewards of hits that depend on the goals.

    Args:
        landing: (B, 2) m, where the balls landed.
        speed: (B,) m/s just after the racket.
        topspin: (B,) rad/s just after the racket.
        returned: (B,) whether they are returns.
        goals: (B,).
        weights: of the parts.
    """
    distance = goals.distance(landing)
    landing_only = goals.speed is None and goals.topspin is None
    weight, scale = weights.shot_landing, weights.shot_landing_scale
    if landing_only:
        weight, scale = weights.landing, weights.landing_scale
    far = weights.far / (1.0 + distance / weights.far_scale)
    near = weight * np.exp(-distance / scale) + far
    style = np.zeros(len(distance))
    if goals.speed is not None:
        difference = np.abs(speed - goals.speed)
        style += weights.speed * np.exp(-difference / weights.speed_scale)
    if goals.topspin is not None:
        difference = np.abs(topspin - goals.topspin)
        style += weights.topspin * np.exp(-difference / weights.topspin_scale)
    return near + np.where(returned, style, 0.0)


def miss_reward(nearest: Floats, weights: RewardSettings) -> Floats:
    """Return the (B,) rewards of misses by ``nearest`` (B,) m."""
    return -np.minimum(weights.miss * nearest, 1.0)


def effort_reward(actions: Floats, weights: RewardSettings) -> Floats:
    """Return the (B,) effort penalties of (B, 5) actions."""
    return -weights.effort * (actions**2).sum(axis=1)
