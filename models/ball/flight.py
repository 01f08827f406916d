"""Equations of motion in flight, and a Runge-Kutta step.

A state is a tuple of nine floats here ``(p, v, w)``: tuples stay in registers.
"""

import math

from rallygap.models.ball.compose import compiled, composed
from rallygap.models.ball.quantities import Air
from rallygap.models.ball.state import BALL_RADIUS, DRAG_FACTOR, MAGNUS_FACTOR
from rallygap.models.ball.types import Environment, Parameters, State

_wind = composed()["wind"]
_gravity = composed()["gravity"]
_gravity_tilt = composed()["gravity_tilt"]
_drag_coefficient = composed()["drag_coefficient"]
_magnus_coefficient = composed()["magnus_coefficient"]
_specific_force = composed()["specific_force"]
_inertia = composed()["inertia"]
_spin_damping = composed()["spin_damping"]


@compiled
def flight_environment(p: Parameters) -> Environment:
    """Return wind (3) and gravitational acceleration (3), constant in flight."""
    tilt_x, tilt_y = _gravity_tilt(p)
    g = _gravity(p)
    down = math.sqrt(1.0 - tilt_x * tilt_x - tilt_y * tilt_y)
    return _wind(p), (g * tilt_x, g * tilt_y, -g * down)


@compiled
def derivative(state: State, p: Parameters, environment: Environment) -> State:
    """Return the time derivative of a state.

    ``dv/dt = [g - kD |u| u + kM (w x u) + f] / inertia`` and ``dw/dt = -c |u| w`` with ``u`` the
    velocity relative to the air (Nakashima 2010, extended by the quantities of the catalogue). A
    drag coefficient below zero counts as zero: drag never accelerates a ball.

    Args:
        state: nine floats.
        p: parameter vector of the simulator.
        environment: what ``flight_environment(p)`` returns.
    """
    _, _, _, vx, vy, vz, wx, wy, wz = state
    (wind_x, wind_y, wind_z), (gx, gy, gz) = environment
    ux, uy, uz = vx - wind_x, vy - wind_y, vz - wind_z
    speed = math.sqrt(ux * ux + uy * uy + uz * uz)
    surface_speed = BALL_RADIUS * math.sqrt(wx * wx + wy * wy + wz * wz)
    ratio = surface_speed / speed if speed > 0.0 else 0.0
    air = Air((ux, uy, uz), (wx, wy, wz), speed, ratio)

    fx, fy, fz = _specific_force(air, p)
    drag = DRAG_FACTOR * _drag_coefficient(air, p) * speed
    if drag < 0.0:  # a branch never taken costs less than a maximum
        drag = 0.0
    lift = MAGNUS_FACTOR * _magnus_coefficient(air, p)
    share = 1.0 / _inertia(air, p)
    damping = _spin_damping(air, p) * speed
    return (
        vx,
        vy,
        vz,
        share * (gx - drag * ux + lift * (wy * uz - wz * uy) + fx),
        share * (gy - drag * uy + lift * (wz * ux - wx * uz) + fy),
        share * (gz - drag * uz + lift * (wx * uy - wy * ux) + fz),
        -damping * wx,
        -damping * wy,
        -damping * wz,
    )


@compiled
def advance(state: State, slope: State, h: float) -> State:
    """Return the state after ``h`` seconds at a constant slope."""
    return (
        state[0] + h * slope[0],
        state[1] + h * slope[1],
        state[2] + h * slope[2],
        state[3] + h * slope[3],
        state[4] + h * slope[4],
        state[5] + h * slope[5],
        state[6] + h * slope[6],
        state[7] + h * slope[7],
        state[8] + h * slope[8],
    )


@compiled
def step(state: State, h: float, p: Parameters, environment: Environment) -> State:
    """Return the state after ``h`` seconds of free flight: one classical Runge-Kutta step."""
    k1 = derivative(state, p, environment)
    k2 = derivative(advance(state, k1, h / 2), p, environment)
    k3 = derivative(advance(state, k2, h / 2), p, environment)
    k4 = derivative(advance(state, k3, h), p, environment)
    half = advance(advance(state, k1, h / 6), k2, h / 3)
    return advance(advance(half, k3, h / 3), k4, h / 6)
