"""Positions of the arm's links and racket, for the 3-D views of the report page."""

import numpy as np
from numpy.typing import ArrayLike, NDArray

from rallygap.models.robot.constants import BASE, BLADE, JOINTS

Floats = NDArray[np.float64]

DRAWN = ("shoulder", "elbow", "wrist_yaw")  # joints at which the drawn links meet


def arm_lines(joints: ArrayLike) -> tuple[Floats, Floats]:
    """Return the arm at T poses.

    Args:
        joints: (T, 6).

    Returns:
        (T, 4, 3) m: shoulder, elbow, wrist and the racket's centre; (T, 3) the racket's normal.
    """
    values = np.asarray(joints, dtype=np.float64)
    rotation = np.broadcast_to(np.eye(3), (len(values), 3, 3))
    point = np.broadcast_to(np.array(BASE), (len(values), 3))
    corners = []
    for joint, value in zip(JOINTS, values.T, strict=True):
        axis = "xyz".index(joint.axis)
        point = point + rotation @ np.array(joint.origin)
        rotation = rotation @ _about(0, np.full(len(values), joint.pitch))
        if joint.kind == "prismatic":
            point = point + rotation[:, :, axis] * value[:, None]
        else:
            rotation = rotation @ _about(axis, value)
        if joint.name in DRAWN:
            corners.append(point)
    return np.stack([*corners, point + rotation @ np.array(BLADE)], axis=1), rotation[:, :, 1]


def _about(axis: int, angles: Floats) -> Floats:
    """Return (T, 3, 3) rotation matrices about an axis."""
    first, second = (axis + 1) % 3, (axis + 2) % 3
    turns = np.zeros((len(angles), 3, 3))
    turns[:, axis, axis] = 1.0
    turns[:, first, first] = turns[:, second, second] = np.cos(angles)
    turns[:, second, first] = np.sin(angles)
    turns[:, first, second] = -np.sin(angles)
    return turns
