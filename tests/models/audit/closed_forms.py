"""Flights in a vacuum with one bounce, in closed form, as engines of other people may have them."""

import numpy as np

from rallygap.models.ball.state import BALL_RADIUS
from rallygap.models.engines.engine import FunctionEngine

GRAVITY = 9.81
SOLID = 2 / 7


def bouncing(cap=SOLID, friction=0.3, restitution=lambda ball: 0.9):
    """An engine whose contact takes at most ``cap`` of the slip; restitution is by state."""

    def fly(states, times):
        return np.array(
            [[_at(one, t, cap, friction, restitution(one)) for t in times] for one in states]
        )

    return FunctionEngine("closed form", fly)


def _at(ball, time, cap, friction, restitution):
    above, fall = ball[2] - BALL_RADIUS, -ball[5]
    contact = (np.sqrt(fall**2 + 2 * GRAVITY * above) - fall) / GRAVITY
    if time <= contact:
        return _fallen(ball, time)
    before = _fallen(ball, contact)
    slip = before[3:5] + BALL_RADIUS * np.array([-before[7], before[6]])
    impulse = friction * (1 + restitution) * -before[5] / max(np.linalg.norm(slip), 1e-9)
    change = -min(impulse, cap) * slip
    inertia = cap / (1 - cap)  # I / m r^2
    after = before.copy()
    after[3:5] += change
    after[5] *= -restitution
    after[6:8] += np.array([change[1], -change[0]]) / (inertia * BALL_RADIUS)
    return _fallen(after, time - contact)


def _fallen(ball, time):
    fallen = ball.copy()
    fallen[:3] += time * ball[3:6] - [0, 0, GRAVITY * time**2 / 2]
    fallen[5] -= GRAVITY * time
    return fallen
