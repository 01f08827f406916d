"""Contact laws of table, net and racket, and the gap between ball and surface.

All three surfaces follow one law in the frame of their normal ``n`` (Nakashima 2010, 2011): with
the velocity of the ball's contact point ``v_b = v_t - r (w x n)``,

    v' = v - (1 + e) v_n n - alpha v_b,        w' = w + 3 alpha / (2 r) (n x v_b).

The angular momentum about the contact point is conserved exactly. The surfaces differ in alpha:
table and net slide until they roll, the racket's rubber grips.
"""

import math

from rallygap.models.ball.compose import compiled, composed
from rallygap.models.ball.quantities import Impact
from rallygap.models.ball.state import (
    BALL_RADIUS,
    NET_HEIGHT,
    NET_OVERHANG,
    TABLE_HALF_LENGTH,
    TABLE_HALF_WIDTH,
)
from rallygap.models.ball.types import Parameters, Scene, State, Vector

_table_restitution = composed()["table_restitution"]
_table_friction = composed()["table_friction"]
_table_elasticity = composed()["table_elasticity"]
_table_height = composed()["table_height"]
_table_tilt = composed()["table_tilt"]
_net_restitution = composed()["net_restitution"]
_net_friction = composed()["net_friction"]
_racket_restitution = composed()["racket_restitution"]
_racket_grip = composed()["racket_grip"]

# Surfaces, as roll-outs number them.
NONE, TABLE, NET = 0, 1, 2

ROLLING = 2.0 / 5.0  # the alpha at which a thin shell leaves rolling
NET_HALF_WIDTH = TABLE_HALF_WIDTH + NET_OVERHANG
AT_REST = Impact(0.0, 0.0, 0.0)


@compiled
def _unit(value: float) -> float:
    return min(max(value, 0.0), 1.0)


@compiled
def _impact(state: State, normal: Vector) -> tuple[float, Vector, Impact]:
    """Return normal velocity, slip velocity of the contact point and the hooks' context."""
    _, _, _, vx, vy, vz, wx, wy, wz = state
    nx, ny, nz = normal
    along = vx * nx + vy * ny + vz * nz
    slip_x = vx - along * nx - BALL_RADIUS * (wy * nz - wz * ny)
    slip_y = vy - along * ny - BALL_RADIUS * (wz * nx - wx * nz)
    slip_z = vz - along * nz - BALL_RADIUS * (wx * ny - wy * nx)
    slip = math.sqrt(slip_x * slip_x + slip_y * slip_y + slip_z * slip_z)
    twist = wx * nx + wy * ny + wz * nz
    in_plane = max(wx * wx + wy * wy + wz * wz - twist * twist, 0.0)
    return along, (slip_x, slip_y, slip_z), Impact(-along, slip, BALL_RADIUS * math.sqrt(in_plane))


@compiled
def _apply_impulse(
    state: State, normal: Vector, along: float, slip: Vector, restitution: float, alpha: float
) -> State:
    px, py, pz, vx, vy, vz, wx, wy, wz = state
    nx, ny, nz = normal
    sx, sy, sz = slip
    push = (1.0 + restitution) * along
    turn = 1.5 * alpha / BALL_RADIUS
    return (
        px,
        py,
        pz,
        vx - push * nx - alpha * sx,
        vy - push * ny - alpha * sy,
        vz - push * nz - alpha * sz,
        wx + turn * (ny * sz - nz * sy),
        wy + turn * (nz * sx - nx * sz),
        wz + turn * (nx * sy - ny * sx),
    )


@compiled
def bounce(state: State, normal: Vector, surface: int, p: Parameters) -> State:
    """Return the state just after a contact with the table or the net.

    ``alpha = mu (1 + e) |v_n| / |v_b|`` while the ball slides, at most ``2/5 (1 + e_t)``. A ball
    that moves away from the surface is unchanged.
    """
    along, slip, impact = _impact(state, normal)
    if along >= 0.0:
        return state
    if surface == TABLE:
        restitution = _unit(_table_restitution(impact, p))
        friction = max(_table_friction(impact, p), 0.0)
        limit = ROLLING * (1.0 + _unit(_table_elasticity(impact, p)))
    else:
        restitution = _unit(_net_restitution(impact, p))
        friction = max(_net_friction(impact, p), 0.0)
        limit = ROLLING
    grip = friction * (1.0 + restitution) * impact.normal_speed
    alpha = limit if grip >= limit * impact.slip else grip / impact.slip
    return _apply_impulse(state, normal, along, slip, restitution, alpha)


@compiled
def racket_contact(state: State, normal: Vector, velocity: Vector, p: Parameters) -> State:
    """Return the state just after a contact with a racket that moves at ``velocity``.

    ``normal`` points from the racket to the ball. A ball that moves away from the racket, or a
    simulator without a racket, leaves the state as it is.
    """
    rx, ry, rz = velocity
    px, py, pz, vx, vy, vz, wx, wy, wz = state
    relative = (px, py, pz, vx - rx, vy - ry, vz - rz, wx, wy, wz)
    along, slip, impact = _impact(relative, normal)
    if along >= 0.0 or not surface_present(_racket_restitution(AT_REST, p)):
        return state
    restitution = _unit(_racket_restitution(impact, p))
    after = _apply_impulse(relative, normal, along, slip, restitution, _racket_grip(impact, p))
    px, py, pz, vx, vy, vz, wx, wy, wz = after
    return (px, py, pz, vx + rx, vy + ry, vz + rz, wx, wy, wz)


@compiled
def surface_present(restitution: float) -> bool:
    """Return whether a surface of this restitution, met at rest, is there.

    It is -1 without the surface and at least 0 with it; midway, because effects that depend on
    the impact may shift either a little.
    """
    return restitution > -0.5


@compiled
def surfaces(p: Parameters) -> Scene:
    """Return (table is there, net is there, surface height, unit normal of the surface)."""
    tilt_x, tilt_y = _table_tilt(p)
    up = 1.0 / math.sqrt(1.0 + tilt_x * tilt_x + tilt_y * tilt_y)
    return (
        surface_present(_table_restitution(AT_REST, p)),
        surface_present(_net_restitution(AT_REST, p)),
        _table_height(p),
        (up * tilt_x, up * tilt_y, up),
    )


@compiled
def _clamp(value: float, limit: float) -> float:
    return min(max(value, -limit), limit)


@compiled
def _from_point(dx: float, dy: float, dz: float) -> tuple[float, Vector]:
    distance = math.sqrt(dx * dx + dy * dy + dz * dz)
    if distance == 0.0:
        return -BALL_RADIUS, (0.0, 0.0, 1.0)
    return distance - BALL_RADIUS, (dx / distance, dy / distance, dz / distance)


@compiled
def table_gap(x: float, y: float, z: float, height: float, up: Vector) -> tuple[float, Vector]:
    """Return the gap between ball and table plate (m) and the normal from the plate to the ball.

    The plate is a rectangle without thickness; beyond its border the nearest point is on an edge.
    A ball whose centre reads less than half a radius below the plate was measured from above: no
    ball from below comes that near.
    """
    nx, ny, nz = up
    above = nx * x + ny * y + nz * (z - height)
    foot_x, foot_y = x - above * nx, y - above * ny
    edge_x, edge_y = _clamp(foot_x, TABLE_HALF_WIDTH), _clamp(foot_y, TABLE_HALF_LENGTH)
    if edge_x == foot_x and edge_y == foot_y:
        side = 1.0 if above >= -0.5 * BALL_RADIUS else -1.0
        return side * above - BALL_RADIUS, (side * nx, side * ny, side * nz)
    return _from_point(x - edge_x, y - edge_y, z - (height - (nx * edge_x + ny * edge_y) / nz))


@compiled
def net_gap(x: float, y: float, z: float, height: float) -> tuple[float, Vector]:
    """Return the gap between ball and net (m) and the normal from the net to the ball.

    The net stands on the table, wherever the surface is.
    """
    foot_x, foot_z = _clamp(x, NET_HALF_WIDTH), min(max(z, height), height + NET_HEIGHT)
    return _from_point(x - foot_x, y, z - foot_z)
