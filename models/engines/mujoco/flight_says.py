"""What a scene says about flight, as effects of ours."""

from collections.abc import Iterable

import mujoco
import numpy as np

from rallygap.models.ball.state import DRAG_FACTOR, MAGNUS_FACTOR
from rallygap.models.ball.types import Floats
from rallygap.models.engines.mujoco.air import Air, air_of, has_air
from rallygap.models.engines.mujoco.ball import Ball
from rallygap.models.engines.mujoco.frame import TableFrame
from rallygap.models.engines.mujoco.notes import Effects

TINY = 1e-6  # of a parameter: a smaller one is none


def flight_effects(model: mujoco.MjModel, ball: Ball, frame: TableFrame) -> Effects:
    """Return the effects of gravity and air of a scene, in the table frame.

    Drag and lift are those that give the scene's accelerations with our constants of air and ball,
    from which those of the scene may differ.
    """
    air, pull = air_of(model, ball), gravity(model, frame)
    effects = {"gravity": {"g": _downwards(pull)}}
    effects |= _effect("frame_tilt", "xy", _tilt(pull))
    effects |= _effect("wind", "xyz", wind(model, frame))
    effects["drag"] = {"cd": air.drag / ball.mass / DRAG_FACTOR}
    effects["magnus"] = {"cm": air.lift / ball.mass / MAGNUS_FACTOR}
    effects |= _effect("linear_drag", ["k1"], [linear_drag(model, ball, air)])
    return effects | _effect("buoyancy", "b", [model.body_gravcomp[ball.body] / MAGNUS_FACTOR])


def gravity(model: mujoco.MjModel, frame: TableFrame) -> Floats:
    """Return the (3,) acceleration of free fall in the table frame, m/s^2."""
    off = model.opt.disableflags & mujoco.mjtDisableBit.mjDSBL_GRAVITY
    pull: Floats = np.zeros(3) if off else model.opt.gravity @ frame.axes
    return pull


def wind(model: mujoco.MjModel, frame: TableFrame) -> Floats:
    """Return the (3,) velocity of the air in the table frame, m/s; zero in a vacuum."""
    blows: Floats = model.opt.wind @ frame.axes if has_air(model) else np.zeros(3)
    return blows


def linear_drag(model: mujoco.MjModel, ball: Ball, air: Air) -> float:
    """Return the drag of viscosity and of the free joint's damping over the velocity, 1/s."""
    return float(air.viscous_drag + model.dof_damping[ball.velocity]) / ball.mass


def _downwards(pull: Floats) -> float:
    """Return the size of gravity, below zero where it points upwards."""
    return float(np.copysign(np.linalg.norm(pull), -pull[2]))


def _tilt(pull: Floats) -> Floats:
    size = float(np.linalg.norm(pull))
    return np.arcsin(pull[:2] / size) if size > 0.0 else np.zeros(2)


def _effect(name: str, parameters: Iterable[str], values: Iterable[float]) -> Effects:
    """Return an effect with its parameters, or nothing where all are zero."""
    listed = {one: float(value) for one, value in zip(parameters, values, strict=True)}
    return {name: listed} if max(map(abs, listed.values())) > TINY else {}
