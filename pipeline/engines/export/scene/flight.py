"""Attributes of a scene that give its ball a flight: the inverse of what a scene states."""

import math
from collections.abc import Mapping
from typing import Any

import mujoco
import numpy as np

from rallygap.models.ball.simulator import Simulator
from rallygap.models.ball.state import AIR_DENSITY, DRAG_FACTOR, MAGNUS_FACTOR
from rallygap.models.ball.types import Floats
from rallygap.models.engines.mujoco.air import is_sphere, shaped_geoms
from rallygap.models.engines.mujoco.scene import MujocoScene
from rallygap.models.engines.mujoco.stated import stated_effects
from rallygap.pipeline.engines.export.scene.change import ROUNDING, Change, Element
from rallygap.pipeline.runtime.errors import InputError

SAME = 1e-4  # relative; and of the unit of a number that is zero
AIR = {"wind_x", "wind_y", "wind_z", "drag", "lift", "linear", "spin_loss"}
FALL = {"fall", "tilt_x", "tilt_y"}
DECIMALS = 6  # of fluidcoef, whose added mass MuJoCo integrates to so many
NO_PASSIVE = mujoco.mjtDisableBit.mjDSBL_SPRING | mujoco.mjtDisableBit.mjDSBL_DAMPER
NO_GRAVITY = mujoco.mjtDisableBit.mjDSBL_GRAVITY

Numbers = dict[str, float]


def flight_numbers(effects: Mapping[str, Mapping[str, Any]]) -> Numbers:
    """Return what MuJoCo has attributes for, of a list of effects.

    Added mass is in these numbers: it divides all forces, also that of gravity.

    Returns:
        ``fall`` (m/s^2, the size of gravity, with buoyancy), ``tilt_x`` and ``tilt_y`` (sines of
        its tilt), ``wind_x``, ``wind_y`` and ``wind_z`` (m/s), ``drag`` (C_D), ``lift`` (C_M),
        ``linear`` (k1, 1/s), and ``spin_loss`` (c of ``spin_decay``, 1/m), which has no attribute.
    """

    def value(effect: str, parameter: str) -> float:
        return float(effects.get(effect, {}).get(parameter, 0.0))

    share = 1.0 / (1.0 + 0.5 * MAGNUS_FACTOR * value("added_mass", "c"))
    carried = 1.0 - MAGNUS_FACTOR * value("buoyancy", "b")
    return {
        "fall": share * carried * value("gravity", "g"),
        "tilt_x": math.sin(value("frame_tilt", "x")),
        "tilt_y": math.sin(value("frame_tilt", "y")),
        "wind_x": value("wind", "x"),
        "wind_y": value("wind", "y"),
        "wind_z": value("wind", "z"),
        "drag": share * value("drag", "cd"),
        "lift": share * value("magnus", "cm"),
        "linear": share * value("linear_drag", "k1"),
        "spin_loss": value("spin_decay", "c"),
    }


def differs(before: float, after: float) -> bool:
    """Return whether two values of a parameter differ."""
    return not math.isclose(before, after, rel_tol=SAME, abs_tol=SAME)


def flight_changes(scene: MujocoScene, before: Simulator, after: Simulator) -> list[Change]:
    """Return the changes of ``<option>`` and of the ball's geom with which a scene flies as a list.

    What is the same ``before`` and ``after`` keeps its attribute, even if the scene does something
    else than the attribute states, because of its time step. Numbers of the air come together,
    because each needs air of some density, in which wind blows.

    Raises:
        InputError: a flag switches gravity or the air off, or the air acts on other geoms, too.
    """
    did, does = flight_numbers(before.effects), flight_numbers(after.effects)
    changed = {name for name, number in does.items() if differs(did[name], number)}
    target = flight_numbers(stated_effects(scene)) | {name: does[name] for name in changed}
    wanted: dict[str, float | Floats] = {}
    if FALL & changed:
        _check_flag(scene, NO_GRAVITY, "gravity")
        wanted["gravity"] = _gravity(scene, target)
    if AIR & changed:
        _check_flag(scene, NO_PASSIVE, "all passive forces, that of the air among them,")
        wind = np.array([target["wind_x"], target["wind_y"], target["wind_z"]])
        wanted["wind"] = scene.frame.axes @ wind
        wanted["density"] = _density(scene, target)
        wanted["viscosity"] = _viscosity(scene, target)
    option = scene.model.opt
    changes = [
        Change.of(Element("option"), name, value)
        for name, value in wanted.items()
        if not np.allclose(getattr(option, name), value, rtol=ROUNDING, atol=ROUNDING)
    ]
    return changes + (_ball_changes(scene, target, changed) if AIR & changed else [])


def _ball_changes(scene: MujocoScene, target: Numbers, changed: set[str]) -> list[Change]:
    model, geom = scene.model, scene.ball.geom
    shaped = shaped_geoms(model, scene.ball)
    if set(shaped) - {geom} or not is_sphere(model, geom):
        problem = "the air acts on several geoms of the ball; give fluidshape to its sphere alone"
        raise InputError(scene.name, problem)
    known, wanted = model.geom_fluid[geom, 1:6], _coefficients(scene, target, changed)
    element = Element("geom", geom)
    changes = [] if shaped else [Change.of(element, "fluidshape", 1.0)]
    if not shaped or not np.allclose(known, wanted, rtol=ROUNDING, atol=ROUNDING):
        changes.append(Change.of(element, "fluidcoef", wanted))
    return changes


def _density(scene: MujocoScene, target: Numbers) -> float:
    """Return the density of the air, kg/m^3: that of the scene, where it has one or needs none."""
    known = float(scene.model.opt.density)
    return known if known > 0.0 or not (target["drag"] or target["lift"]) else AIR_DENSITY


def _gravity(scene: MujocoScene, target: Numbers) -> Floats:
    """Return the (3,) attribute; the compensation of the ball's body remains."""
    x, y = target["tilt_x"], target["tilt_y"]
    pull = target["fall"] * np.array([x, y, -math.sqrt(1.0 - x**2 - y**2)])
    share = 1.0 - float(scene.model.body_gravcomp[scene.ball.body])
    if share == 0.0:
        problem = "gravcomp of the ball is 1, so it has no gravity; take it away"
        raise InputError(scene.name, problem)
    return np.asarray(scene.frame.axes @ pull / share)


def _viscosity(scene: MujocoScene, target: Numbers) -> float:
    """Return the attribute that gives the linear drag, with the damping of the joint."""
    ball = scene.ball
    missing = target["linear"] * ball.mass - float(scene.model.dof_damping[ball.velocity])
    return max(missing, 0.0) / (6.0 * math.pi * ball.radius)


def _coefficients(scene: MujocoScene, target: Numbers, changed: set[str]) -> Floats:
    """Return the (5,) attribute ``fluidcoef``.

    The third number slows spin, in proportion to spin and not to speed. It remains where a list
    describes it as before, and else is 0.
    """
    ball, air = scene.ball, _density(scene, target)
    drag, second, brake, fourth, lift, added = scene.model.geom_fluid[ball.geom, 1:7].tolist()
    volume = 4.0 / 3.0 * math.pi * ball.radius**3
    if air > 0.0:
        drag = target["drag"] * DRAG_FACTOR * ball.mass / (air * math.pi * ball.radius**2)
        lift = target["lift"] * MAGNUS_FACTOR * ball.mass / air / volume
        lift += added / volume if added > 0.0 else 0.5
    brake = 0.0 if "spin_loss" in changed else brake
    return np.round([drag, second, brake, fourth, lift], DECIMALS)


def _check_flag(scene: MujocoScene, flag: int, what: str) -> None:
    if scene.model.opt.disableflags & flag == flag:
        problem = f"a <flag> of the scene switches {what} off; take it away"
        raise InputError(scene.name, problem)
