"""What the attributes of a scene stand for: a list of effects, read without flying it."""

from collections.abc import Iterable

import mujoco
import numpy as np

from rallygap.models.ball.state import BALL_RADIUS, DRAG_FACTOR, MAGNUS_FACTOR
from rallygap.models.ball.types import Floats
from rallygap.models.engines.mujoco.air import air_of, has_air
from rallygap.models.engines.mujoco.contact import table_contact
from rallygap.models.engines.mujoco.frame import TableFrame
from rallygap.models.engines.mujoco.scene import MujocoScene

Effects = dict[str, dict[str, float]]
"""Effect name -> parameter name -> value, as a simulator lists them."""

TINY = 1e-6  # of a parameter: a smaller one is none


def stated_effects(scene: MujocoScene) -> Effects:
    """Return the scene as a list of effects, in the table frame.

    Drag and lift are those that give the scene's accelerations with our constants of air and ball,
    from which those of the scene may differ. Values may be outside of what a simulator accepts; a
    note says so (notes.py). Without a contact with the table there is neither bounce nor height.
    """
    model, ball, frame = scene.model, scene.ball, scene.frame
    air, pull = air_of(model, ball), gravity(model, frame)
    size = float(np.linalg.norm(pull))
    effects = {"gravity": {"g": float(np.copysign(size, -pull[2]))}}  # below zero: upwards
    tilt = np.arcsin(pull[:2] / size) if size > 0.0 else np.zeros(2)
    effects |= _effect("frame_tilt", "xy", tilt)
    wind = model.opt.wind @ frame.axes if has_air(model) else np.zeros(3)
    effects |= _effect("wind", "xyz", wind)
    effects["drag"] = {"cd": air.drag / ball.mass / DRAG_FACTOR}
    effects["magnus"] = {"cm": air.lift / ball.mass / MAGNUS_FACTOR}
    # Of viscosity and of the free joint's damping.
    linear = float(air.viscous_drag + model.dof_damping[ball.velocity]) / ball.mass
    effects |= _effect("linear_drag", ["k1"], [linear])
    effects |= _effect("buoyancy", "b", [model.body_gravcomp[ball.body] / MAGNUS_FACTOR])
    contact = table_contact(model, ball, frame)
    if contact is not None:
        bounce = {"restitution": contact.restitution, "friction": contact.friction[0]}
        effects["table_bounce"] = bounce
        height = ball.radius - BALL_RADIUS + contact.lift
        effects |= _effect("table_height", "h", [height])
    return effects


def gravity(model: mujoco.MjModel, frame: TableFrame) -> Floats:
    """Return the (3,) acceleration of free fall in the table frame, m/s^2."""
    off = model.opt.disableflags & mujoco.mjtDisableBit.mjDSBL_GRAVITY
    return np.zeros(3) if off else model.opt.gravity @ frame.axes


def _effect(name: str, parameters: Iterable[str], values: Iterable[float]) -> Effects:
    """Return an effect with its parameters, or nothing where all are zero."""
    listed = {key: float(value) for key, value in zip(parameters, values, strict=True)}
    return {name: listed} if max(map(abs, listed.values())) > TINY else {}
