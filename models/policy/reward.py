"""The reward.

A hit is rewarded more the nearer the ball comes to the goal, returned or not, so that the reward
has a gradient from the first contact on.
"""

import numpy as np

from rallygap.models.ball.state import BALL_RADIUS, NET_HEIGHT
from rallygap.models.ball.types import Bools, Floats
from rallygap.models.policy.goals import Goals
from rallygap.models.policy.outcome import Outcome

CONTACT = 0.5  # for any hit
LANDING, LANDING_SCALE = 3.0, 0.6  # m: gradient for landings near the goal
FAR, FAR_SCALE = 0.3, 1.0  # m: gradient for balls metres away
NET, NET_DEPTH = 0.5, 0.3  # m below the clearance at which the penalty is full
NET_CLEARANCE = NET_HEIGHT + BALL_RADIUS + 0.03  # m: 3 cm between ball and net
RETURN = 1.0
BACKHAND = 0.5  # penalty: a policy with one face learns faster

# Optional goals. Large and narrow, or they are hardly followed: a faster stroke costs accuracy of
# the landing, which then has to weigh more as well.
SHOT_LANDING, SHOT_LANDING_SCALE = 12.0, 0.4  # m
SPEED, SPEED_SCALE = 12.0, 0.8  # m/s
TOPSPIN, TOPSPIN_SCALE = 8.0, 60.0  # rad/s

NEAREST_SLOPE = 2.0  # 1/m: saturates at half a metre
FAULT = 1.0  # penalty: as large as the worst miss, or the policy would prefer a fault
EFFORT = 0.002  # per control step, times the squared action: a full action costs 0.01


def contact_reward(outcome: Outcome, backhand: Bools) -> Floats:
    """Return the (B,) parts of the rewards of hits that do not depend on the goals."""
    low = NET * np.clip((NET_CLEARANCE - outcome.net_height) / NET_DEPTH, 0.0, 1.0)
    return CONTACT - low - BACKHAND * backhand + RETURN * outcome.returned


def goal_reward(
    landing: Floats, speed: Floats, topspin: Floats, returned: Bools, goals: Goals
) -> Floats:
    """Return the (B,) parts of the rewards of hits that depend on the goals.

    Args:
        landing: (B, 2) m, where the balls landed.
        speed: (B,) m/s just after the racket.
        topspin: (B,) rad/s just after the racket.
        returned: (B,) whether they are returns.
        goals: (B,).
    """
    distance = goals.distance(landing)
    landing_only = goals.speed is None and goals.topspin is None
    weight, scale = (LANDING, LANDING_SCALE) if landing_only else (SHOT_LANDING, SHOT_LANDING_SCALE)
    near = weight * np.exp(-distance / scale) + FAR / (1.0 + distance / FAR_SCALE)
    style = np.zeros(len(distance))
    if goals.speed is not None:
        style += SPEED * np.exp(-np.abs(speed - goals.speed) / SPEED_SCALE)
    if goals.topspin is not None:
        style += TOPSPIN * np.exp(-np.abs(topspin - goals.topspin) / TOPSPIN_SCALE)
    return near + np.where(returned, style, 0.0)


def miss_reward(nearest: Floats) -> Floats:
    """Return the (B,) rewards of misses by ``nearest`` (B,) m."""
    return -np.minimum(NEAREST_SLOPE * nearest, 1.0)


def effort_reward(actions: Floats) -> Floats:
    """Return the (B,) effort penalties of (B, 5) actions."""
    return -EFFORT * (actions**2).sum(axis=1)
