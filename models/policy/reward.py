"""Reward: what the policy is taught.

A ball that is struck is worth more the nearer it comes to the goal, returned or not, so that
learning has a slope to climb from the first touch on.
"""

import numpy as np
from numpy.typing import NDArray

from models.ball.state import BALL_RADIUS, NET_HEIGHT
from models.policy.goals import Goals
from models.policy.outcome import Outcome

Floats = NDArray[np.float64]
Booleans = NDArray[np.bool_]

CONTACT = 0.5  # for touching the ball at all
LANDING, LANDING_SCALE = 3.0, 0.6  # m: the slope that a landing on the table feels
FAR, FAR_SCALE = 0.3, 1.0  # m: the slope that is left for balls metres away
NET, NET_DEPTH = 0.5, 0.3  # m below the clearance at which the whole penalty is due
NET_CLEARANCE = NET_HEIGHT + BALL_RADIUS + 0.03  # m: 3 cm of air between ball and net
RETURN = 1.0
BACKHAND = 0.5  # penalty: one face for all balls is found sooner than two

# Goals that not every policy is given. Worth far more than a landing and falling off soon, or they
# are hardly followed: to strike faster, an arm must give up certainty of where the ball lands.
SPEED, SPEED_SCALE = 12.0, 0.8  # m/s
TOPSPIN, TOPSPIN_SCALE = 8.0, 60.0  # rad/s

NEAREST_SLOPE = 2.0  # 1/m: a ball missed by half a metre or more is missed altogether
FAULT = 1.0  # penalty: as bad as the worst miss, or the policy would seek it
EFFORT = 0.002  # a tick, times the squared action: five full actions cost 0.01


def contact_reward(outcome: Outcome, backhand: Booleans) -> Floats:
    """Return what (B,) strokes are worth whatever their goals, ``backhand`` (B,) if by the back."""
    low = NET * np.clip((NET_CLEARANCE - outcome.net_height) / NET_DEPTH, 0.0, 1.0)
    worth: Floats = CONTACT - low - BACKHAND * backhand + RETURN * outcome.returned
    return worth


def goal_reward(
    landing: Floats, speed: Floats, topspin: Floats, returned: Booleans, goals: Goals
) -> Floats:
    """Return what (B,) strokes are worth besides, under any goals.

    Args:
        landing: (B, 2) m, where the balls landed.
        speed: (B,) m/s just after the racket.
        topspin: (B,) rad/s just after the racket.
        returned: (B,) whether they landed as they must.
        goals: (B,) that were to be reached.
    """
    distance = goals.distance(landing)
    near = LANDING * np.exp(-distance / LANDING_SCALE) + FAR / (1.0 + distance / FAR_SCALE)
    style = np.zeros(len(distance))
    if goals.speed is not None:
        style += SPEED * np.exp(-np.abs(speed - goals.speed) / SPEED_SCALE)
    if goals.topspin is not None:
        style += TOPSPIN * np.exp(-np.abs(topspin - goals.topspin) / TOPSPIN_SCALE)
    worth: Floats = near + np.where(returned, style, 0.0)
    return worth


def miss_reward(nearest: Floats) -> Floats:
    """Return the (B,) rewards of balls missed by ``nearest`` metres."""
    missed: Floats = -np.minimum(NEAREST_SLOPE * nearest, 1.0)
    return missed


def effort_reward(actions: Floats) -> Floats:
    """Return the (B,) rewards of (B, 5) actions: calm arms are preferred."""
    effort: Floats = -EFFORT * (actions**2).sum(axis=1)
    return effort
