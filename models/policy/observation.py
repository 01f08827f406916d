"""Observations of the policy, scaled to about [-1, 1]."""

import numpy as np
from numpy.typing import NDArray

from rallygap.models.ball.state import STATE_SIZE
from rallygap.models.ball.types import Floats
from rallygap.models.policy.goals import Goals
from rallygap.models.policy.settings import ObservationKind
from rallygap.models.robot.constants import LOWER, NEUTRAL, SPEED, UPPER
from rallygap.models.robot.kinematics import Racket, racket

Observations = NDArray[np.float32]

WITH_CROSSING = ("intercept", "spread")  # kinds of observation
LIMIT = 5.0  # clips every value: a diverged forecast must not saturate the network

_MIDDLE, _HALF_RANGE = 0.5 * (UPPER + LOWER), 0.5 * (UPPER - LOWER)
_HOME = racket(NEUTRAL[None], NEUTRAL[None]).position[0]

ROBOT_SIZE = 2 * len(NEUTRAL) + 9  # joints, joint speeds, racket pose and velocity
RACKET_REACH = 0.5  # m around neutral
RACKET_SPEED = 3.0  # m/s

# Typical balls on the robot's half and behind it: m, m/s and rad/s.
BALL_CENTRE = np.array([0.0, -0.8, 0.2, 0.0, -5.0, 0.0, 0.0, 0.0, 0.0])
BALL_SCALE = np.array([0.5, 1.0, 0.3, 1.5, 4.0, 3.0, 150.0, 150.0, 150.0])

# Where the ball crosses the racket's plane under gravity alone.
GRAVITY = 9.81  # m/s^2
SLOWEST = 0.5  # m/s: slower balls are treated as if they approached at this speed
EARLIEST, LATEST = -0.5, 1.0  # s
CROSSING_SCALE = np.array([0.3, 0.5, 0.5, 1.5, 4.0, 3.0])  # s, m, m, m/s
SPREAD_SCALE = 0.03  # m


def observe(
    joints: Floats,
    speeds: Floats,
    forecasts: Floats,
    spreads: Floats | None,
    goals: Goals,
    kind: ObservationKind,
) -> Observations:
    """Return the (B, O) observations of B environments.

    Args:
        joints: (B, 6) m and rad.
        speeds: (B, 6) m/s and rad/s.
        forecasts: (B, H, 9) forecast states, nearest horizon first.
        spreads: (B, H, 3) m, standard deviations of the forecast positions.
        goals: (B,).
        kind: of observation, as ``ObservationKind`` says.

    Raises:
        ValueError: ``spread`` without spreads.
    """
    racket_state = racket(joints, speeds)
    parts = [
        (joints - _MIDDLE) / _HALF_RANGE,
        speeds / SPEED,
        (racket_state.position - _HOME) / RACKET_REACH,
        racket_state.normal,
        racket_state.velocity / RACKET_SPEED,
        ((forecasts - BALL_CENTRE) / BALL_SCALE).reshape(len(joints), -1),
        goals.scaled(),
    ]
    if kind in WITH_CROSSING:
        parts.append(plane_crossing(racket_state, forecasts[:, 0]) / CROSSING_SCALE)
    if kind == "spread":
        if spreads is None:
            raise ValueError("this policy observes spreads, but its predictor has none")
        parts.append(spreads.reshape(len(joints), -1) / SPREAD_SCALE)
    return np.clip(np.concatenate(parts, axis=1), -LIMIT, LIMIT).astype(np.float32)


def plane_crossing(racket_state: Racket, balls: Floats) -> Floats:
    """Return (B, 6) when, where and how fast balls cross the plane y = constant of the racket.

    Under gravity alone from (B, 9) states: time (s), offsets across and above the racket (m), and
    velocity (m/s).
    """
    position, velocity = balls[:, :3], balls[:, 3:6]
    approach = np.minimum(velocity[:, 1], -SLOWEST)
    time = np.clip((racket_state.position[:, 1] - position[:, 1]) / approach, EARLIEST, LATEST)
    across = position[:, 0] + velocity[:, 0] * time - racket_state.position[:, 0]
    falling = velocity[:, 2] - GRAVITY * time
    above = position[:, 2] + 0.5 * (velocity[:, 2] + falling) * time - racket_state.position[:, 2]
    return np.column_stack([time, across, above, velocity[:, 0], velocity[:, 1], falling])


def goal_slice(horizons: int, goals: int) -> slice:
    """Return the columns of an observation that hold the goal."""
    first = ROBOT_SIZE + horizons * STATE_SIZE
    return slice(first, first + goals)


def observation_size(horizons: int, goals: int, kind: ObservationKind) -> int:
    """Return the size of an observation."""
    crossings = len(CROSSING_SCALE) if kind in WITH_CROSSING else 0
    spreads = 3 * horizons if kind == "spread" else 0
    return ROBOT_SIZE + horizons * STATE_SIZE + goals + crossings + spreads
