"""Laws of the independent dynamics: other functional forms of the catalogue's effects.

Only the dimensions of ball and table are shared with the simulator. An effect that is a definition
(gravity, a tilted table) has one form. Where physics leaves the form open, the form differs from
the catalogue's, scaled so that its constant is near the catalogue's parameter;
``equivalent_sizes`` finds the constant to which a best fit of the catalogue's form corresponds.
"""

import math
from pathlib import Path
from typing import NamedTuple

import numpy as np

from rallygap.models.ball import state as ball
from rallygap.models.ball.catalogue import catalogue
from rallygap.models.ball.simulator import Simulator
from rallygap.models.ball.state import AIR_DENSITY, BALL_AREA, BALL_MASS, BALL_RADIUS, BALL_VOLUME
from rallygap.models.ball.types import Floats
from rallygap.models.support.compilation import compiler

compiled = compiler([Path(__file__), Path(str(ball.__file__))])

# Forms that differ from the catalogue's; all other effects follow their definition.
FORMS = {
    "speed_dependent_drag": "C_D + c f(Re), f tabulated: flat, a fall towards the crisis, flat",
    "spin_dependent_drag": "C_D + c (f(S) - f(0.5)), f tabulated: slow at first, levelling off",
    "lift_saturation": "C_M (1 + kappa f(0.5)) / (1 + kappa f(S)), f tabulated, levelling off",
    "lift_crisis": "C_M (1 - d / (1 + ((S - 0.5) / 0.2)^2) smoothstep(|u| from 10 to 12))",
    "spin_decay": "dw/dt = -c sqrt(8 |u|) w, the torque of a laminar boundary layer",
    "wind": "grows with the height over the table as (z / 0.25)^(1/4)",
    "side_force": "C_Y (|u| / 8)^-0.3",
    "speed_dependent_restitution": "e (v_n / 2.5)^-p, p = 2.5 c / e",
    "spin_dependent_restitution": "e + 1.15 c (sqrt(4 + (r w_t)^2) - 3.6)",
    "slip_dependent_friction": "Stribeck: mu + 10.9 c (exp(-1) - exp(-|v_b| / 4)), through contact",
    "tangential_elasticity": "slip returns as e_t (1 - exp(-q / 0.12)), q the impulse left to grip",
}

AIR_VISCOSITY = 1.5e-5  # m^2/s
DRAG_REYNOLDS = np.array([5e3, 1.1e4, 1.6e4, 2.1e4, 2.7e4, 3.2e4, 4e4, 5.3e4])
DRAG_OF_REYNOLDS = np.array([-0.75, -0.60, -0.35, 0.0, 0.50, 0.85, 1.15, 1.30])
SPIN_RATIO = np.array([0.0, 0.1, 0.2, 0.4, 0.7, 1.0, 1.5, 2.5, 5.0])
DRAG_OF_SPIN = np.array([0.0, 0.06, 0.16, 0.42, 0.78, 1.05, 1.35, 1.70, 2.0])
SATURATION_OF_SPIN = np.array([0.0, 0.21, 0.40, 0.74, 1.16, 1.50, 1.95, 2.50, 3.2])

TYPICAL_SPIN = 0.5  # spin ratio at which drag and lift have their nominal coefficients
DRAG_OF_TYPICAL_SPIN = float(np.interp(TYPICAL_SPIN, SPIN_RATIO, DRAG_OF_SPIN))
SATURATION_OF_TYPICAL_SPIN = float(np.interp(TYPICAL_SPIN, SPIN_RATIO, SATURATION_OF_SPIN))

CONTACT_STEPS = 16  # of the normal impulse


class Physics(NamedTuple):
    """Constants of the independent dynamics, one a parameter of the catalogue."""

    gravity_g: float
    drag_cd: float
    magnus_cm: float
    table_bounce_restitution: float
    table_bounce_friction: float
    speed_dependent_drag_c: float
    spin_dependent_drag_c: float
    linear_drag_k1: float
    lift_saturation_kappa: float
    lift_crisis_d: float
    spin_decay_c: float
    wind_x: float
    wind_y: float
    wind_z: float
    frame_tilt_x: float
    frame_tilt_y: float
    buoyancy_b: float
    added_mass_c: float
    side_force_cy: float
    speed_dependent_restitution_c: float
    spin_dependent_restitution_c: float
    slip_dependent_friction_c: float
    tangential_elasticity_et: float
    table_height_h: float
    table_tilt_x: float
    table_tilt_y: float


def supports(effect: str) -> bool:
    """Return whether the independent dynamics have an effect; all share the sensor model."""
    known = catalogue()[effect]
    fields = {f"{effect}_{parameter.name}" for parameter in known.parameters}
    return known.acts == "sensor" or fields <= set(Physics._fields)


def physics_of(simulator: Simulator) -> Physics:
    """Return constants that equal a simulator's parameters. Rackets are left out.

    Raises:
        ValueError: the simulator has no table, or an effect without an independent form.
    """
    if "table_bounce" not in simulator.effects:
        raise ValueError("the independent dynamics have a table; the simulator has no table_bounce")
    values = {
        f"{name}_{p.name}": p.neutral for name, e in catalogue().items() for p in e.parameters
    }
    for effect, parameters in simulator.effects.items():
        if effect != "racket_bounce" and not supports(effect):
            raise ValueError(f"the independent dynamics do not have {effect}")
        values |= {f"{effect}_{name}": value for name, value in parameters.items()}
    return Physics(**{name: values[name] for name in Physics._fields})


@compiled
def derivative(y: Floats, q: Physics, slope: Floats) -> None:
    """Write the time derivative of a state (9,) of free flight into ``slope`` (9,)."""
    layer = (max(y[2], BALL_RADIUS) / 0.25) ** 0.25
    ux, uy, uz = y[3] - layer * q.wind_x, y[4] - layer * q.wind_y, y[5] - layer * q.wind_z
    wx, wy, wz = y[6], y[7], y[8]
    speed = max(math.sqrt(ux * ux + uy * uy + uz * uz), 1e-9)
    ratio = BALL_RADIUS * math.sqrt(wx * wx + wy * wy + wz * wz) / speed

    drag = _drag(speed, ratio, q)
    lift = AIR_DENSITY * BALL_VOLUME / BALL_MASS * _lift(speed, ratio, q)
    side = 0.5 * AIR_DENSITY * BALL_AREA / BALL_MASS * q.side_force_cy
    side *= speed**2 * (speed / 8.0) ** -0.3 / max(math.hypot(ux, uy), 1e-9)
    g = q.gravity_g * (1.0 - q.buoyancy_b * AIR_DENSITY * BALL_VOLUME / BALL_MASS)
    gx, gy = g * math.sin(q.frame_tilt_x), g * math.sin(q.frame_tilt_y)
    gz = -math.sqrt(g * g - gx * gx - gy * gy)
    inertia = 1.0 + 0.5 * q.added_mass_c * AIR_DENSITY * BALL_VOLUME / BALL_MASS
    torque = q.spin_decay_c * math.sqrt(8.0 * speed)

    slope[0], slope[1], slope[2] = y[3], y[4], y[5]
    slope[3] = (gx - drag * ux + lift * (wy * uz - wz * uy) + side * uy) / inertia
    slope[4] = (gy - drag * uy + lift * (wz * ux - wx * uz) - side * ux) / inertia
    slope[5] = (gz - drag * uz + lift * (wx * uy - wy * ux)) / inertia
    slope[6], slope[7], slope[8] = -torque * wx, -torque * wy, -torque * wz


@compiled
def _drag(speed: float, ratio: float, q: Physics) -> float:
    """Return the deceleration by drag over the speed, 1/s."""
    coefficient = q.drag_cd
    if q.speed_dependent_drag_c != 0.0:
        reynolds = 2.0 * BALL_RADIUS * speed / AIR_VISCOSITY
        shape = np.interp(reynolds, DRAG_REYNOLDS, DRAG_OF_REYNOLDS)
        coefficient += q.speed_dependent_drag_c * shape
    if q.spin_dependent_drag_c != 0.0:
        shape = np.interp(ratio, SPIN_RATIO, DRAG_OF_SPIN) - DRAG_OF_TYPICAL_SPIN
        coefficient += q.spin_dependent_drag_c * shape
    quadratic = 0.5 * AIR_DENSITY * BALL_AREA / BALL_MASS * max(coefficient, 0.0) * speed
    return quadratic + q.linear_drag_k1


@compiled
def _lift(speed: float, ratio: float, q: Physics) -> float:
    """Return C_M."""
    coefficient = q.magnus_cm
    if q.lift_saturation_kappa != 0.0:
        shape = np.interp(ratio, SPIN_RATIO, SATURATION_OF_SPIN)
        coefficient *= 1.0 + q.lift_saturation_kappa * SATURATION_OF_TYPICAL_SPIN
        coefficient /= 1.0 + q.lift_saturation_kappa * shape
    if q.lift_crisis_d != 0.0:
        rise = min(max((speed - 10.0) / 2.0, 0.0), 1.0)
        dip = rise * rise * (3.0 - 2.0 * rise) / (1.0 + ((ratio - 0.5) / 0.2) ** 2)
        coefficient *= 1.0 - q.lift_crisis_d * dip
    return coefficient


@compiled
def normal_of(q: Physics) -> tuple[float, float, float]:
    """Return the table's unit normal."""
    x, y = math.sin(q.table_tilt_x), math.sin(q.table_tilt_y)
    length = math.sqrt(1.0 + x * x + y * y)
    return x / length, y / length, 1.0 / length


@compiled
def bounce(y: Floats, q: Physics) -> None:
    """Turn a state (9,) just before a contact with the table into the one just after.

    Coulomb friction acts during the contact, against the slip at each moment, until the ball rolls.
    With constant friction this equals the instantaneous contact law.
    """
    nx, ny, nz = normal_of(q)
    fall = -(y[3] * nx + y[4] * ny + y[5] * nz)
    sx = y[3] + fall * nx - BALL_RADIUS * (y[7] * nz - y[8] * ny)
    sy = y[4] + fall * ny - BALL_RADIUS * (y[8] * nx - y[6] * nz)
    sz = y[5] + fall * nz - BALL_RADIUS * (y[6] * ny - y[7] * nx)
    slip = math.sqrt(sx * sx + sy * sy + sz * sz)
    twist = y[6] * nx + y[7] * ny + y[8] * nz
    spin = BALL_RADIUS * math.sqrt(max(y[6] ** 2 + y[7] ** 2 + y[8] ** 2 - twist**2, 0.0))

    push = (1.0 + _restitution(fall, spin, q)) * fall
    share = 0.4 * (1.0 - _slip_after(slip, push, q) / slip) if slip > 0.0 else 0.0
    y[3] += push * nx - share * sx
    y[4] += push * ny - share * sy
    y[5] += push * nz - share * sz
    turn = 1.5 * share / BALL_RADIUS
    y[6] += turn * (ny * sz - nz * sy)
    y[7] += turn * (nz * sx - nx * sz)
    y[8] += turn * (nx * sy - ny * sx)


@compiled
def _restitution(fall: float, spin: float, q: Physics) -> float:
    e = q.table_bounce_restitution
    if q.speed_dependent_restitution_c != 0.0:
        e *= (fall / 2.5) ** (-2.5 * q.speed_dependent_restitution_c / q.table_bounce_restitution)
    e += 1.15 * q.spin_dependent_restitution_c * (math.sqrt(4.0 + spin * spin) - 3.6)
    return min(max(e, 0.0), 1.0)


@compiled
def _friction(slip: float, q: Physics) -> float:
    stribeck = 10.9 * (math.exp(-1.0) - math.exp(-max(slip, 0.0) / 4.0))
    return max(q.table_bounce_friction + q.slip_dependent_friction_c * stribeck, 0.0)


@compiled
def _slip_after(slip: float, push: float, q: Physics) -> float:
    """Return the slip after a contact of normal impulse ``push`` (over the mass, m/s).

    A thin shell loses 5/2 mu of slip for each unit of it (midpoint rule); a negative slip is
    elastic, returned by the table.
    """
    h = push / CONTACT_STEPS
    now = slip
    for k in range(CONTACT_STEPS):
        half = now - 1.25 * _friction(now, q) * h
        loss = 2.5 * _friction(half, q) * h
        if loss >= now:
            left = (CONTACT_STEPS - k - now / loss) / CONTACT_STEPS if loss > 0.0 else 0.0
            return -q.tangential_elasticity_et * slip * (1.0 - math.exp(-left / 0.12))
        now -= loss
    return now
