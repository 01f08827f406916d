"""Swept contact of ball and racket: no ball passes through a blade between two samples."""

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from rallygap.models.ball.state import BALL_RADIUS
from rallygap.models.ball.types import Bools, Floats, Integers, Vector
from rallygap.models.robot.constants import RACKET_RADIUS
from rallygap.models.robot.kinematics import Racket, compiled

_UNMOVED = 1e-20  # m^2; a ball that moves less along the blade counts as not moving


@dataclass(frozen=True)
class Contact:
    """Whether and when B balls touch their rackets within a step."""

    met: Bools  # (B,)
    share: Floats  # (B,) of the step until the contact, 0 to 1; NaN without a contact
    side: Integers  # (B,) +1 for the racket's face, -1 for its back, 0 without a contact


def first_contact(
    ball_before: ArrayLike, ball_after: ArrayLike, racket_before: Racket, racket_after: Racket
) -> Contact:
    """Return the first contacts within a step.

    A ball touches a racket when its centre is over the blade (at most the blade's radius from the
    axis), its surface touches the blade's plane, and it approaches. Touching the rim alone does not
    count: rubber is on the faces. Relative to the racket the ball moves on a straight line, which
    is exact to 0.2 mm in steps of 1 ms.

    Args:
        ball_before: (B, 3) m, the balls' centres at the beginning of the step.
        ball_after: (B, 3) m, at its end.
        racket_before: the B rackets at the beginning.
        racket_after: the B rackets at the end.
    """
    before = np.subtract(ball_before, racket_before.position, dtype=np.float64)
    after = np.subtract(ball_after, racket_after.position, dtype=np.float64)
    share, side = _contacts(before, after, racket_before.normal, racket_after.normal)
    return Contact(side != 0, share, side)


@compiled
def _contacts(
    before: Floats, after: Floats, first: Floats, last: Floats
) -> tuple[Floats, Integers]:
    """Return share and side for (B, 3) balls relative to rackets with these normals."""
    share, side = np.full(len(before), np.nan), np.zeros(len(before), dtype=np.int64)
    for k in range(len(before)):
        a = (before[k, 0], before[k, 1], before[k, 2])
        b = (after[k, 0], after[k, 1], after[k, 2])
        n = (first[k, 0], first[k, 1], first[k, 2])
        m = (last[k, 0], last[k, 1], last[k, 2])
        share[k], side[k] = _line_contact(a, _rotate(b, m, n), n)
    return share, side


@compiled
def _line_contact(a: Vector, b: Vector, n: Vector) -> tuple[float, int]:
    """Return share and side of the line from a to b towards a blade at the origin."""
    height, rise = _dot(a, n), _dot(b, n) - _dot(a, n)
    if rise == 0.0:
        return math.nan, 0
    side = -1 if rise > 0.0 else 1
    # From the first touch until the centre is in the blade's plane.
    touch, inside = (side * BALL_RADIUS - height) / rise, -height / rise
    enter, leave = _over_blade(_in_plane(a, n), _in_plane(b, n))
    moment = max(touch, enter, 0.0)
    if moment >= inside or moment > min(leave, 1.0):
        return math.nan, 0
    return moment, side


@compiled
def _over_blade(a: Vector, b: Vector) -> tuple[float, float]:
    """Return the shares between which a line in the blade's plane is within the blade."""
    along = (b[0] - a[0], b[1] - a[1], b[2] - a[2])
    square, half = _dot(along, along), _dot(a, along)
    beyond = _dot(a, a) - RACKET_RADIUS**2
    if square < _UNMOVED:
        return (-math.inf, math.inf) if beyond <= 0.0 else (math.inf, -math.inf)
    inside = half * half - square * beyond
    if inside < 0.0:
        return math.inf, -math.inf
    root = math.sqrt(inside)
    return (-half - root) / square, (-half + root) / square


@compiled
def _in_plane(a: Vector, n: Vector) -> Vector:
    """Return the part of a vector that is in the plane with normal n."""
    height = _dot(a, n)
    return a[0] - height * n[0], a[1] - height * n[1], a[2] - height * n[2]


@compiled
def _rotate(b: Vector, m: Vector, n: Vector) -> Vector:
    """Return b rotated by the smallest rotation that takes normal m to n."""
    axis = _cross(m, n)
    once = _cross(axis, b)
    twice = _cross(axis, once)
    share = 1.0 / (1.0 + _dot(m, n))
    return (
        b[0] + once[0] + share * twice[0],
        b[1] + once[1] + share * twice[1],
        b[2] + once[2] + share * twice[2],
    )


@compiled
def _dot(a: Vector, b: Vector) -> float:
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]


@compiled
def _cross(a: Vector, b: Vector) -> Vector:
    return (a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0])
