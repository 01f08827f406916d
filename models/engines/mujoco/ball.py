"""The ball in a scene: the free body that collides as one sphere of a ball's size."""

from dataclasses import dataclass

import mujoco
import numpy as np

from rallygap.models.engines.engine import EngineError
from rallygap.models.support.suggestion import suggestion

SMALLEST, LARGEST = 0.015, 0.025  # m, radii that a table-tennis ball may have in a scene
OFF_CENTRE = 1e-6  # m, between the centre of the sphere and the origin of its body
# Units of length other than the metre, and how many of them a metre has.
UNITS = {"centimetres": 100.0, "millimetres": 1000.0}


@dataclass(frozen=True)
class Ball:
    """The ball of a scene.

    Attributes:
        name: of its body.
        body: index of its body.
        geom: index of its sphere.
        position: index of the first of its seven numbers in ``qpos``: position and quaternion.
        velocity: index of the first of its six numbers in ``qvel``: velocity (m/s), in the world's
            frame, and spin (rad/s), in the body's.
        radius: m.
        mass: kg.
    """

    name: str
    body: int
    geom: int
    position: int
    velocity: int
    radius: float
    mass: float


def find_ball(model: mujoco.MjModel, name: str | None = None) -> Ball:
    """Find the ball of a scene.

    Args:
        model: the scene.
        name: of the ball's body; None to take the only body that can be the ball.

    Raises:
        EngineError: no body or several bodies can be the ball, or the named one cannot.
    """
    if name is not None:
        return _named(model, name)
    fit = [body for body in range(1, model.nbody) if _flaw(model, body) is None]
    if len(fit) > 1:
        names = ", ".join(body_name(model, body) for body in fit)
        raise EngineError(f"{len(fit)} bodies can be the ball: {names}; name one of them")
    if not fit:
        raise EngineError(_none_found(model))
    return _ball(model, fit[0])


def body_name(model: mujoco.MjModel, body: int) -> str:
    """Return the name of a body, or its number where it has none."""
    return model.body(body).name or f"body {body}"


def _named(model: mujoco.MjModel, name: str) -> Ball:
    body = mujoco.mj_name2id(model, mujoco.mjtObj.mjOBJ_BODY, name)
    if body < 0:
        known = [model.body(other).name for other in range(1, model.nbody)]
        hint = suggestion(name, filter(None, known))
        raise EngineError(f"there is no body called {name!r}; {hint}")
    flaw = _flaw(model, body)
    if flaw is not None:
        raise EngineError(f"the body {name!r} cannot be the ball: it {flaw}")
    return _ball(model, body)


def _ball(model: mujoco.MjModel, body: int) -> Ball:
    joint, geom = model.body_jntadr[body], _shapes(model, body)[0]
    return Ball(
        name=body_name(model, body),
        body=body,
        geom=geom,
        position=int(model.jnt_qposadr[joint]),
        velocity=int(model.jnt_dofadr[joint]),
        radius=float(model.geom_size[geom, 0]),
        mass=float(model.body_mass[body]),
    )


def _none_found(model: mujoco.MjModel) -> str:
    wanted = (
        "there is no ball, that is a body with a free joint whose only geom that collides is a "
        f"sphere with a radius of {1000 * SMALLEST:g} to {1000 * LARGEST:g} mm"
    )
    near = [body for body in range(1, model.nbody) if _resembles(model, body)]
    flaws = [f"{body_name(model, body)} {_flaw(model, body)}" for body in near]
    return f"{wanted}; {'; '.join(flaws) or 'no body is free, and none is one sphere'}"


def _resembles(model: mujoco.MjModel, body: int) -> bool:
    return _is_free(model, body) or _is_one_sphere(model, _shapes(model, body))


def _flaw(model: mujoco.MjModel, body: int) -> str | None:
    """Return why a body cannot be the ball, as the end of a sentence; None if it can."""
    shapes = _shapes(model, body)
    if not _is_free(model, body):
        return "has no free joint; give it <freejoint/>"
    if not _is_one_sphere(model, shapes):
        kinds = " and ".join(_kind(model, geom) for geom in shapes) or "nothing"
        advice = "let one sphere collide, and give others contype and conaffinity 0"
        return f"collides as {kinds}; {advice}"
    return _flaw_of_sphere(model, body, shapes[0])


def _flaw_of_sphere(model: mujoco.MjModel, body: int, geom: int) -> str | None:
    radius = float(model.geom_size[geom, 0])
    for unit, per_metre in UNITS.items():
        if SMALLEST <= radius / per_metre <= LARGEST:
            return f"has a radius of {radius:g}, so the scene is in {unit}; write it in metres"
    if not SMALLEST <= radius <= LARGEST:
        return f"has a radius of {1000 * radius:g} mm; a ball has 20 mm"
    if np.abs([model.geom_pos[geom], model.body_ipos[body]]).max() > OFF_CENTRE:
        return "has its sphere or its mass off its origin; put both at the body's origin"
    return None


def _is_free(model: mujoco.MjModel, body: int) -> bool:
    first = model.body_jntadr[body]
    return bool(first >= 0 and model.jnt_type[first] == mujoco.mjtJoint.mjJNT_FREE)


def _is_one_sphere(model: mujoco.MjModel, geoms: list[int]) -> bool:
    return len(geoms) == 1 and model.geom_type[geoms[0]] == mujoco.mjtGeom.mjGEOM_SPHERE


def _kind(model: mujoco.MjModel, geom: int) -> str:
    name: str = mujoco.mjtGeom(int(model.geom_type[geom])).name
    return name.removeprefix("mjGEOM_").lower()


def _shapes(model: mujoco.MjModel, body: int) -> list[int]:
    """Return the geoms of a body that collide; all of them where none does."""
    first = int(model.body_geomadr[body])
    geoms = list(range(first, first + int(model.body_geomnum[body])))
    paired = {*model.pair_geom1.tolist(), *model.pair_geom2.tolist()}
    masks = model.geom_contype | model.geom_conaffinity
    return [geom for geom in geoms if masks[geom] or geom in paired] or geoms
