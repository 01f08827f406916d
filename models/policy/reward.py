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
LANDING, LANDING_SCALE = 1.5, 0.6  # m: the slope that a landing on the table feels
FAR, FAR_SCALE = 0.3, 1.0  # m: the slope that is left for balls metres away
NET, NET_DEPTH = 0.5, 0.3  # m below the clearance at which the whole penalty is due
NET_CLEARANCE = NET_HEIGHT + BALL_RADIUS + 0.03  # m: 3 cm of air between ball and net
RETURN = 1.0
BACKHAND = 0.5  # penalty: one face for all balls is found sooner than two

# Goals that not every policy is given; a goal met is worth half a return.
SPEED, SPEED_SCALE = 0.5, 1.5  # m/s
TOPSPIN, TOPSPIN_SCALE = 0.5, 50.0  # rad/s

NEAREST_SLOPE = 2.0  # 1/m: a ball missed by half a metre or more is missed altogether
FAULT = 1.0  # penalty: as bad as the worst miss, or the policy would seek it
EFFORT = 0.002  # a tick, times the squared action: five full actions cost 0.01


def contact_reward(outcome: Outcome, backhand: Booleans, goals: Goals) -> Floats:
    """Return the (B,) rewards of balls that were struck.

    Args:
        outcome: of the (B,) balls.
        backhand: (B,) whether the racket's back met the ball.
        goals: (B,) that were to be reached.
    """
    landing = LANDING * np.exp(-outcome.distance / LANDING_SCALE)
    far = FAR / (1.0 + outcome.distance / FAR_SCALE)
    low = NET * np.clip((NET_CLEARANCE - outcome.net_height) / NET_DEPTH, 0.0, 1.0)
    returned = RETURN + _style(outcome, goals)
    total: Floats = CONTACT + landing + far - low - BACKHAND * backhand
    return total + np.where(outcome.returned, returned, 0.0)


def miss_reward(nearest: Floats) -> Floats:
    """Return the (B,) rewards of balls missed by ``nearest`` metres."""
    missed: Floats = -np.minimum(NEAREST_SLOPE * nearest, 1.0)
    return missed


def effort_reward(actions: Floats) -> Floats:
    """Return the (B,) rewards of (B, 5) actions: calm arms are preferred."""
    effort: Floats = -EFFORT * (actions**2).sum(axis=1)
    return effort


def _style(outcome: Outcome, goals: Goals) -> Floats:
    """Return how well the speed and the topspin that were asked for are met."""
    style = np.zeros(len(outcome.speed))
    if goals.speed is not None:
        style += SPEED * np.exp(-np.abs(outcome.speed - goals.speed) / SPEED_SCALE)
    if goals.topspin is not None:
        style += TOPSPIN * np.exp(-np.abs(outcome.topspin - goals.topspin) / TOPSPIN_SCALE)
    return style
