"""The forces of the air on the ball of a scene, as MuJoCo makes them of its attributes.

The formulas are those of MuJoCo's documentation, "Fluid forces", and of its source
(``engine_passive.c``). With ``fluidshape="ellipsoid"`` a sphere of radius r and volume V meets

    force  = -(6 pi beta r + rho c0 pi r^2 |u|) u + rho (c4 - 1/2) V (w x u),
    torque = -(8 pi beta r^3 + rho c2 8/15 pi r^5 |w|) w,

where 1/2 V is the volume whose mass is added (MuJoCo integrates it numerically, to 6e-7 of it); c1
and c3 do nothing. Without it MuJoCo takes the body for the box with the same inertia.
"""

import math
from dataclasses import dataclass

import mujoco
import numpy as np

from rallygap.models.engines.mujoco.ball import Ball

# Mean over the directions n of the sum of |n_i|^3: of a box's drag over that along an axis.
MEAN_DIRECTION = 0.75


@dataclass(frozen=True)
class Air:
    """Coefficients of the forces and torques on a ball of spin w at velocity u through the air.

    Attributes:
        shaped: whether the ball has ``fluidshape="ellipsoid"``, or flies in a vacuum. Otherwise
            ``drag`` and ``spin_drag`` are means over the orientations of the ball.
        drag: of -|u| u, kg/m.
        viscous_drag: of -u, kg/s.
        lift: of w x u, kg.
        spin_drag: of -|w| w, kg m^2.
        viscous_spin_drag: of -w, kg m^2/s.
    """

    shaped: bool
    drag: float
    viscous_drag: float
    lift: float
    spin_drag: float
    viscous_spin_drag: float


def air_of(model: mujoco.MjModel, ball: Ball) -> Air:
    """Return what the air does to the ball."""
    if not has_air(model):
        return Air(True, 0.0, 0.0, 0.0, 0.0, 0.0)
    spheres = [geom for geom in shaped_geoms(model, ball) if is_sphere(model, geom)]
    if not shaped_geoms(model, ball):
        return _of_box(model, ball)
    return Air(True, *np.sum([_of_sphere(model, geom) for geom in spheres], axis=0).tolist())


def has_air(model: mujoco.MjModel) -> bool:
    """Return whether a scene has air. MuJoCo leaves it out where all passive forces are off."""
    off = mujoco.mjtDisableBit.mjDSBL_SPRING | mujoco.mjtDisableBit.mjDSBL_DAMPER
    filled = model.opt.density > 0.0 or model.opt.viscosity > 0.0
    return bool(filled and model.opt.disableflags & off != off)


def shaped_geoms(model: mujoco.MjModel, ball: Ball) -> list[int]:
    """Return the geoms of the ball's body that the air acts on as ellipsoids."""
    first = int(model.body_geomadr[ball.body])
    geoms = range(first, first + int(model.body_geomnum[ball.body]))
    return [geom for geom in geoms if model.geom_fluid[geom, 0] > 0.0]


def is_sphere(model: mujoco.MjModel, geom: int) -> bool:
    """Return whether a geom is a sphere."""
    return bool(model.geom_type[geom] == mujoco.mjtGeom.mjGEOM_SPHERE)


def _of_sphere(model: mujoco.MjModel, geom: int) -> tuple[float, float, float, float, float]:
    c0, _, c2, _, c4, added_volume = model.geom_fluid[geom, 1:7]
    r, rho, beta = float(model.geom_size[geom, 0]), model.opt.density, model.opt.viscosity
    return (
        rho * c0 * math.pi * r**2,
        6.0 * math.pi * beta * r,
        rho * (c4 * 4.0 / 3.0 * math.pi * r**3 - added_volume),
        rho * c2 * 8.0 / 15.0 * math.pi * r**5,
        8.0 * math.pi * beta * r**3,
    )


def _of_box(model: mujoco.MjModel, ball: Ball) -> Air:
    """Return the forces on a cube with the ball's inertia (isotropic, as a ball's is)."""
    rho, beta = model.opt.density, model.opt.viscosity
    side = math.sqrt(6.0 * float(model.body_inertia[ball.body].mean()) / ball.mass)
    return Air(
        shaped=False,
        drag=0.5 * rho * side**2 * MEAN_DIRECTION,
        viscous_drag=3.0 * math.pi * beta * side,
        lift=0.0,
        spin_drag=rho * side**5 / 32.0 * MEAN_DIRECTION,
        viscous_spin_drag=math.pi * beta * side**3,
    )
