"""Forward kinematics of the racket, for many arms at once."""

import math
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import ArrayLike

from rallygap.models.ball import state
from rallygap.models.ball.types import Floats, Vector
from rallygap.models.robot.constants import BASE, BLADE, JOINTS
from rallygap.models.support.compilation import compiler

_HERE = Path(__file__).parent
_SOURCES = (_HERE / f"{name}.py" for name in ("constants", "kinematics", "control", "contact"))
compiled = compiler([*_SOURCES, Path(state.__file__)])  # for this package's functions

_AXES = tuple("xyz".index(joint.axis) for joint in JOINTS)
_ORIGINS = tuple(joint.origin for joint in JOINTS)
_PITCHES = tuple(joint.pitch for joint in JOINTS)
_TURNS = tuple(joint.kind == "revolute" for joint in JOINTS)
JOINT_COUNT = len(JOINTS)


@dataclass(frozen=True)
class Racket:
    """B rackets: discs whose face points along the normal, towards +y in neutral."""

    position: Floats  # (B, 3) m, of the centres
    normal: Floats  # (B, 3) unit
    velocity: Floats  # (B, 3) m/s, of the centres
    turning: Floats  # (B, 3) rad/s, angular velocity


def racket(joints: ArrayLike, joint_speeds: ArrayLike) -> Racket:
    """Return the rackets of arms at ``joints`` (B, 6) that move at ``joint_speeds`` (B, 6).

    Raises:
        ValueError: shapes that do not fit.
    """
    at, moving = rows_of_joints(joints), rows_of_joints(joint_speeds)
    if len(at) != len(moving):
        raise ValueError(f"{len(at)} arms, but speeds of {len(moving)}")
    return Racket(*_rackets(at, moving))


def rows_of_joints(values: ArrayLike) -> Floats:
    """Return a contiguous (B, 6) array.

    Raises:
        ValueError: another shape.
    """
    rows = np.ascontiguousarray(values, dtype=np.float64)
    if rows.ndim != 2 or rows.shape[1] != JOINT_COUNT:
        raise ValueError(f"an arm has {JOINT_COUNT} joints: (B, {JOINT_COUNT}), not {rows.shape}")
    return rows


@compiled
def _turn(frame: Floats, axis: int, angle: float) -> None:
    """Turn a frame, whose rows are its axes, about one of them."""
    first, second = (axis + 1) % 3, (axis + 2) % 3
    c, s = math.cos(angle), math.sin(angle)
    for k in range(3):
        u, v = frame[first, k], frame[second, k]
        frame[first, k], frame[second, k] = c * u + s * v, c * v - s * u


@compiled
def _moved(point: Vector, frame: Floats, by: Vector) -> Vector:
    """Return a point displaced by a vector given in a frame."""
    return (
        point[0] + by[0] * frame[0, 0] + by[1] * frame[1, 0] + by[2] * frame[2, 0],
        point[1] + by[0] * frame[0, 1] + by[1] * frame[1, 1] + by[2] * frame[2, 1],
        point[2] + by[0] * frame[0, 2] + by[1] * frame[1, 2] + by[2] * frame[2, 2],
    )


@compiled
def locate(joints: Floats, frame: Floats, columns: Floats) -> Vector:
    """Return the centre of one arm's racket.

    Args:
        joints: (6,).
        frame: (3, 3), filled with the racket's axes as rows: its side, its normal, its upright.
        columns: (6, 6), filled with the Jacobian.
    """
    frame[:] = np.eye(3)
    point = BASE
    pivots = np.empty((JOINT_COUNT, 3))
    for joint in range(JOINT_COUNT):
        axis = _AXES[joint]
        point = _moved(point, frame, _ORIGINS[joint])
        _turn(frame, 0, _PITCHES[joint])
        columns[:3, joint] = columns[3:, joint] = frame[axis]
        if _TURNS[joint]:
            _turn(frame, axis, joints[joint])
        else:
            slid = joints[joint]
            along = (slid * frame[axis, 0], slid * frame[axis, 1], slid * frame[axis, 2])
            point = (point[0] + along[0], point[1] + along[1], point[2] + along[2])
        pivots[joint] = point
    centre = _moved(point, frame, BLADE)
    for joint in range(JOINT_COUNT):
        if not _TURNS[joint]:
            columns[3:, joint] = 0.0
            continue
        ax, ay, az = columns[3, joint], columns[4, joint], columns[5, joint]
        x = centre[0] - pivots[joint, 0]
        y = centre[1] - pivots[joint, 1]
        z = centre[2] - pivots[joint, 2]
        columns[0, joint] = ay * z - az * y
        columns[1, joint] = az * x - ax * z
        columns[2, joint] = ax * y - ay * x
    return centre


@compiled
def _rackets(joints: Floats, joint_speeds: Floats) -> tuple[Floats, Floats, Floats, Floats]:
    position, normal = np.empty((len(joints), 3)), np.empty((len(joints), 3))
    velocity, turning = np.zeros((len(joints), 3)), np.zeros((len(joints), 3))
    frame, columns = np.empty((3, 3)), np.empty((6, JOINT_COUNT))
    for arm in range(len(joints)):
        centre = locate(joints[arm], frame, columns)
        for k in range(3):
            position[arm, k], normal[arm, k] = centre[k], frame[1, k]
            for joint in range(JOINT_COUNT):
                velocity[arm, k] += columns[k, joint] * joint_speeds[arm, joint]
                turning[arm, k] += columns[k + 3, joint] * joint_speeds[arm, joint]
    return position, normal, velocity, turning
