"""Racket velocity control: joint speeds by damped least squares."""

import numpy as np
from numpy.typing import ArrayLike

from rallygap.models.ball.types import Floats
from rallygap.models.robot.constants import LOWER, NEUTRAL, SPEED, UPPER
from rallygap.models.robot.kinematics import JOINT_COUNT, compiled, locate, rows_of_joints

DAMPING = 0.01  # lambda^2: limits joint speeds near singular poses
HOMING = 2.0  # 1/s: rate at which the null space returns to neutral
BRAKING = 0.1  # s in which the bridge, the slowest drive, stops from full speed: 15.05 kg by 300 N
_TASKS = 5  # three velocities of the centre, two turning rates; about its normal a disc is free


def joint_speeds(joints: ArrayLike, velocity: ArrayLike, turning: ArrayLike) -> Floats:
    """Return the (B, 6) joint speeds of one command, within all limits.

    If a joint exceeds its speed limit, all joints are slowed by the same factor, which keeps the
    racket's direction. Near the end of its range a joint gets no more speed than it can brake.

    Args:
        joints: (B, 6).
        velocity: (B, 3) m/s, desired, of the rackets' centres.
        turning: (B, 2) rad/s about the racket's side axis (positive opens the face) and about its
            upright axis (positive turns the face towards -x).

    Raises:
        ValueError: shapes that do not fit.
    """
    at = rows_of_joints(joints)
    tasks = np.concatenate([np.asarray(velocity), np.asarray(turning)], axis=1, dtype=np.float64)
    if tasks.shape != (len(at), _TASKS):
        raise ValueError(f"give velocities ({len(at)}, 3) and turning rates ({len(at)}, 2)")
    speeds = _least_squares(at, tasks)
    excess = np.max(np.abs(speeds) / SPEED, axis=1, keepdims=True)
    room_below, room_above = (LOWER - at) / BRAKING, (UPPER - at) / BRAKING
    return np.clip(speeds / np.maximum(excess, 1.0), room_below, room_above)


@compiled
def _least_squares(joints: Floats, tasks: Floats) -> Floats:
    """Return z + J'(JJ' + lambda^2)^-1 (task - J z), z the speeds towards neutral, for each arm."""
    speeds = np.empty_like(joints)
    frame, columns = np.empty((3, 3)), np.empty((6, JOINT_COUNT))
    task_rows = np.empty((_TASKS, JOINT_COUNT))
    for arm in range(len(joints)):
        locate(joints[arm], frame, columns)
        task_rows[:3] = columns[:3]
        task_rows[3] = frame[0] @ columns[3:]
        task_rows[4] = frame[2] @ columns[3:]
        home = HOMING * (NEUTRAL - joints[arm])
        damped = task_rows @ task_rows.T + DAMPING * np.eye(_TASKS)
        wanted = np.linalg.solve(damped, tasks[arm] - task_rows @ home)
        speeds[arm] = home + task_rows.T @ wanted
    return speeds
