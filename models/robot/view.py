"""Pictures of the arm, the table and the ball, rendered off-screen by Bullet."""

from collections.abc import Sequence

import numpy as np
from numpy.typing import ArrayLike, NDArray

from rallygap.models.ball.state import (
    BALL_RADIUS,
    NET_HEIGHT,
    NET_OVERHANG,
    TABLE_HALF_LENGTH,
    TABLE_HALF_WIDTH,
)
from rallygap.models.ball.types import Floats
from rallygap.models.robot.arms import add_arm, open_world
from rallygap.models.robot.bullet import pybullet
from rallygap.models.robot.constants import FLOOR, TABLE_DEPTH
from rallygap.models.robot.kinematics import rows_of_joints

Image = NDArray[np.uint8]

WIDTH, HEIGHT = 480, 320  # pixels
EYE, TARGET = (2.9, -3.3, 1.40), (-0.05, -0.5, 0.1)  # m: behind the robot, to its right
FIELD_OF_VIEW = 40.0  # degrees, vertical
_BALL_SCALE = 1.75  # drawn larger than it is, or it would be three pixels wide
_OVERSAMPLING = 2  # rendered pixels per pixel, each way: thin lines stay continuous
_LINE = 0.020  # m: ITTF Law 2.1.5; the centre line is drawn a quarter as wide
_ABOVE = 0.002  # m, lines above the table, to be visible

_BLUE, _WHITE, _GREY = (0.08, 0.30, 0.55, 1), (1, 1, 1, 1), (0.75, 0.76, 0.78, 1)
_FLOOR, _ORANGE, _NET = (0.55, 0.47, 0.42, 1), (1.0, 0.55, 0.05, 1), (0.12, 0.14, 0.15, 1)


def frames(joints: ArrayLike, ball_positions: ArrayLike) -> list[Image]:
    """Return T pictures (HEIGHT, WIDTH, 3) RGB.

    Args:
        joints: (T, 6) of the arm in each picture.
        ball_positions: (T, 3) m, of the ball's centre; NaN hides it.

    Raises:
        ValueError: shapes that do not fit.
    """
    poses = rows_of_joints(joints)
    balls = np.asarray(ball_positions, dtype=np.float64)
    if balls.shape != (len(poses), 3):
        raise ValueError(f"{len(poses)} poses, but ball positions of shape {balls.shape}")
    client = open_world()
    try:
        arm, ball = _furnish(client)
        return [_picture(client, arm, ball, *now) for now in zip(poses, balls, strict=True)]
    finally:
        pybullet.disconnect(physicsClientId=client)


def _furnish(client: int) -> tuple[int, int]:
    """Add everything to a world and return the moving bodies, arm and ball."""
    half_width, half_length, half_line = TABLE_HALF_WIDTH, TABLE_HALF_LENGTH, _LINE / 2
    _add_box(client, (4.0, 5.0, 0.01), (0, 0, FLOOR - 0.01), _FLOOR)
    _add_box(client, (half_width, half_length, TABLE_DEPTH / 2), (0, 0, -TABLE_DEPTH / 2), _BLUE)
    for side in (-1, 1):
        _add_box(client, (half_line, half_length, 0), (side * half_width, 0, _ABOVE), _WHITE)
        _add_box(client, (half_width, half_line, 0), (0, side * half_length, _ABOVE), _WHITE)
        for end in (-1, 1):
            support = (side * 0.6, end * 1.0, (FLOOR - TABLE_DEPTH) / 2)
            _add_box(client, (0.03, 0.03, -(FLOOR + TABLE_DEPTH) / 2), support, _GREY)
    _add_box(client, (half_line / 4, half_length, 0), (0, 0, _ABOVE), _WHITE)
    span = half_width + NET_OVERHANG
    _add_box(client, (span, 0.002, NET_HEIGHT / 2), (0, 0, NET_HEIGHT / 2), _NET)
    _add_box(client, (span, 0.006, half_line), (0, 0, NET_HEIGHT), _WHITE)
    sphere = pybullet.createVisualShape(
        pybullet.GEOM_SPHERE,
        radius=_BALL_SCALE * BALL_RADIUS,
        rgbaColor=_ORANGE,
        physicsClientId=client,
    )
    ball: int = pybullet.createMultiBody(0, -1, sphere, physicsClientId=client)
    return add_arm(client), ball


def _add_box(
    client: int, half: Sequence[float], centre: Sequence[float], colour: Sequence[float]
) -> None:
    world = {"physicsClientId": client}
    shape = pybullet.createVisualShape(
        pybullet.GEOM_BOX,
        halfExtents=[max(extent, 0.001) for extent in half],
        rgbaColor=colour,
        **world,
    )
    pybullet.createMultiBody(0, -1, shape, basePosition=centre, **world)


def _picture(client: int, arm: int, ball: int, joints: Floats, position: Floats) -> Image:
    world = {"physicsClientId": client}
    for joint, value in enumerate(joints.tolist()):
        pybullet.resetJointState(arm, joint, value, **world)
    place = np.nan_to_num(position, nan=10 * FLOOR).tolist()  # hidden far below the floor
    pybullet.resetBasePositionAndOrientation(ball, place, [0, 0, 0, 1], **world)
    width, height = WIDTH * _OVERSAMPLING, HEIGHT * _OVERSAMPLING
    _, _, pixels, _, _ = pybullet.getCameraImage(
        width,
        height,
        viewMatrix=pybullet.computeViewMatrix(EYE, TARGET, [0, 0, 1]),
        projectionMatrix=pybullet.computeProjectionMatrixFOV(
            FIELD_OF_VIEW, WIDTH / HEIGHT, 0.5, 12.0
        ),
        lightDirection=[1.5, -1.0, 4.0],
        renderer=pybullet.ER_TINY_RENDERER,
        flags=pybullet.ER_NO_SEGMENTATION_MASK,
        **world,
    )
    drawn = np.reshape(pixels, (HEIGHT, _OVERSAMPLING, WIDTH, _OVERSAMPLING, 4))[..., :3]
    return np.asarray(drawn.mean(axis=(1, 3)).round(), dtype=np.uint8)
