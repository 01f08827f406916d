"""Observation: what the policy sees, scaled to about [-1, 1]."""

import numpy as np
from numpy.typing import NDArray

from models.ball.state import STATE_SIZE
from models.policy.goals import Goals
from models.policy.settings import ObservationKind
from models.robot.constants import LOWER, NEUTRAL, SPEED, UPPER
from models.robot.kinematics import Racket, racket

Floats = NDArray[np.float64]
Observations = NDArray[np.float32]

LIMIT = 5.0  # on every number: a forecast gone astray must not blow up the network

_MIDDLE, _HALF_RANGE = 0.5 * (UPPER + LOWER), 0.5 * (UPPER - LOWER)
_HOME = racket(NEUTRAL[None], NEUTRAL[None]).position[0]

OWN = 2 * len(NEUTRAL) + 9  # numbers of the robot itself
RACKET_REACH = 0.5  # m around neutral
RACKET_SPEED = 3.0  # m/s

# Balls on the robot's half and behind it: m, m/s and rad/s of ordinary strokes.
BALL_CENTRE = np.array([0.0, -0.8, 0.2, 0.0, -5.0, 0.0, 0.0, 0.0, 0.0])
BALL_SCALE = np.array([0.5, 1.0, 0.3, 1.5, 4.0, 3.0, 150.0, 150.0, 150.0])

# The plane of the racket: where the ball would cross it, if gravity alone pulled.
GRAVITY = 9.81  # m/s^2
SLOWEST = 0.5  # m/s: a ball that hardly approaches has no crossing to speak of
EARLIEST, LATEST = -0.5, 1.0  # s
CROSSING_SCALE = np.array([0.3, 0.5, 0.5, 1.5, 4.0, 3.0])  # s, m, m, m/s


def observe(
    joints: Floats, speeds: Floats, forecasts: Floats, goals: Goals, kind: ObservationKind
) -> Observations:
    """Return the (B, O) observations of B arms.

    Args:
        joints: (B, 6) m and rad.
        speeds: (B, 6) m/s and rad/s.
        forecasts: (B, H, 9) states that the predictor says are ahead, nearest first.
        goals: (B,) that are asked for.
        kind: ``strict`` is what the paper's policy sees: robot, forecasts and goal;
            ``intercept`` adds where the nearest forecast would cross the racket's plane.
    """
    hand = racket(joints, speeds)
    parts = [
        (joints - _MIDDLE) / _HALF_RANGE,
        speeds / SPEED,
        (hand.position - _HOME) / RACKET_REACH,
        hand.normal,
        hand.velocity / RACKET_SPEED,
        ((forecasts - BALL_CENTRE) / BALL_SCALE).reshape(len(joints), -1),
        goals.scaled(),
    ]
    if kind == "intercept":
        parts.append(crossing(hand, forecasts[:, 0]) / CROSSING_SCALE)
    seen: Observations = np.clip(np.concatenate(parts, axis=1), -LIMIT, LIMIT).astype(np.float32)
    return seen


def crossing(hand: Racket, balls: Floats) -> Floats:
    """Return (B, 6) when, where and how balls cross the plane y = constant of the racket.

    By gravity alone, from (B, 9) states: s until then, m across and above the racket, and m/s.
    """
    position, velocity = balls[:, :3], balls[:, 3:6]
    approach = np.minimum(velocity[:, 1], -SLOWEST)
    time = np.clip((hand.position[:, 1] - position[:, 1]) / approach, EARLIEST, LATEST)
    across = position[:, 0] + velocity[:, 0] * time - hand.position[:, 0]
    falling = velocity[:, 2] - GRAVITY * time
    above = position[:, 2] + 0.5 * (velocity[:, 2] + falling) * time - hand.position[:, 2]
    return np.column_stack([time, across, above, velocity[:, 0], velocity[:, 1], falling])


def goal_columns(horizons: int, goals: int) -> slice:
    """Return where in an observation the goal stands."""
    first = OWN + horizons * STATE_SIZE
    return slice(first, first + goals)


def observation_size(horizons: int, goals: int, kind: ObservationKind) -> int:
    """Return how many numbers an observation has."""
    crossings = len(CROSSING_SCALE) if kind == "intercept" else 0
    return OWN + horizons * STATE_SIZE + goals + crossings
