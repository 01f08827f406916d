"""Resting contact: a ball that hardly rebounds slides on, without rolling friction."""

import math

from rallygap.models.ball.compose import compiled
from rallygap.models.ball.contact_detection import approach, gap_to, squared_speed
from rallygap.models.ball.contact_laws import NET, TABLE
from rallygap.models.ball.flight import advance, derivative
from rallygap.models.ball.types import Environment, Parameters, Scene, State, Vector

REST_SPEED = 5e-4  # m/s: a slower rebound comes back within 0.1 ms and counts as resting
SLIDE_DISTANCE = 0.005  # m, longest slide of a resting ball per step


@compiled
def _along_surface(state: State, slope: State, normal: Vector, h: float) -> State:
    """Return the state after ``h`` seconds at the part of a constant slope along a surface."""
    nx, ny, nz = normal
    vx, vy, vz, ax, ay, az, wx, wy, wz = slope
    v = vx * nx + vy * ny + vz * nz
    a = ax * nx + ay * ny + az * nz
    flat = (vx - v * nx, vy - v * ny, vz - v * nz, ax - a * nx, ay - a * ny, az - a * nz)
    return advance(state, (*flat, wx, wy, wz), h)


@compiled
def slide(
    state: State,
    normal: Vector,
    surface: int,
    longest: float,
    p: Parameters,
    environment: Environment,
    scene: Scene,
) -> tuple[State, float]:
    """Return the state of a ball that rests on a surface a moment later, and that moment.

    It flies on in the plane of the surface, without rolling friction (midpoint rule).
    """
    along = approach(state, normal)
    state = (
        state[0],
        state[1],
        state[2],
        state[3] - along * normal[0],
        state[4] - along * normal[1],
        state[5] - along * normal[2],
        state[6],
        state[7],
        state[8],
    )
    h = min(longest, SLIDE_DISTANCE / max(math.sqrt(squared_speed(state)), 1e-3))
    half = _along_surface(state, derivative(state, p, environment), normal, 0.5 * h)
    state = _along_surface(state, derivative(half, p, environment), normal, h)
    other = NET if surface == TABLE else TABLE
    return _push_out(other, state, p, environment, scene), h


@compiled
def _push_out(
    surface: int, state: State, p: Parameters, environment: Environment, scene: Scene
) -> State:
    """Move a ball that slid into a surface just outside of it, at the same total energy."""
    gap, normal = gap_to(surface, state[0], state[1], state[2], scene)
    if gap >= 0.0:
        return state
    nx, ny, nz = normal
    pull = min(approach(derivative(state, p, environment), normal), 0.0)
    along = approach(state, normal)
    slower = -math.sqrt(max(along * along + 2.0 * pull * -gap, 0.0)) if along < 0.0 else along
    kick = slower - along
    shift = (-gap * nx, -gap * ny, -gap * nz, kick * nx, kick * ny, kick * nz, 0.0, 0.0, 0.0)
    return advance(state, shift, 1.0)


@compiled
def is_resting(state: State, normal: Vector, p: Parameters, environment: Environment) -> bool:
    """Return whether a ball hardly leaves a surface against which it is pressed."""
    pull = approach(derivative(state, p, environment), normal)
    return approach(state, normal) < REST_SPEED and pull <= 0.0
