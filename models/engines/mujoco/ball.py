"""The ball in a scene: the free body that collides as one sphere of a ball's size."""

from dataclasses import dataclass

import mujoco
import numpy as np

from rallygap.models.engines.engine import EngineError
from rallygap.models.support.suggestion import suggestion

SMALLEST, LARGEST = 0.015, 0.025  # m, radii that a table-tennis ball may have in a scene
SHELL, SOLID = 2.0 / 3.0, 2.0 / 5.0  # moments of inertia over m r^2
SAME_INERTIA = 0.01  # relative
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
    bodies = range(1, model.nbody)
    if name is not None:
        body = mujoco.mj_name2id(model, mujoco.mjtObj.mjOBJ_BODY, name)
        if body < 0:
            hint = suggestion(name, filter(None, (model.body(other).name for other in bodies)))
            raise EngineError(f"there is no body called {name!r}; {hint}")
        flaw = _flaw(model, body)
        if flaw is not None:
            raise EngineError(f"the body {name!r} cannot be the ball: it {flaw}")
        return _ball(model, body)
    fit = [body for body in bodies if _flaw(model, body) is None]
    if len(fit) > 1:
        names = ", ".join(_name(model, body) for body in fit)
        raise EngineError(f"{len(fit)} bodies can be the ball: {names}; name one of them")
    if not fit:
        near = [body for body in bodies if _is_free(model, body) or _is_one_sphere(model, body)]
        flaws = [f"{_name(model, body)} {_flaw(model, body)}" for body in near]
        raise EngineError(
            "there is no ball, that is a body with a free joint whose only geom that collides is a "
            f"sphere with a radius of {1000 * SMALLEST:g} to {1000 * LARGEST:g} mm; "
            f"{'; '.join(flaws) or 'no body is free, and none is one sphere'}"
        )
    return _ball(model, fit[0])


def has_inertia(model: mujoco.MjModel, ball: Ball, share: float) -> bool:
    """Return whether the ball's moments of inertia are this share of m r^2, within 1 %."""
    shares = model.body_inertia[ball.body] / (ball.mass * ball.radius**2)
    return bool(np.allclose(shares, share, rtol=SAME_INERTIA))


def _ball(model: mujoco.MjModel, body: int) -> Ball:
    joint, geom = model.body_jntadr[body], _shapes(model, body)[0]
    return Ball(
        name=_name(model, body),
        body=body,
        geom=geom,
        position=int(model.jnt_qposadr[joint]),
        velocity=int(model.jnt_dofadr[joint]),
        radius=float(model.geom_size[geom, 0]),
        mass=float(model.body_mass[body]),
    )


def _name(model: mujoco.MjModel, body: int) -> str:
    return model.body(body).name or f"body {body}"


def _flaw(model: mujoco.MjModel, body: int) -> str | None:
    """Return why a body cannot be the ball, as the end of a sentence; None if it can."""
    if not _is_free(model, body):
        return "has no free joint; give it <freejoint/>"
    shapes = _shapes(model, body)
    if not _is_one_sphere(model, body):
        kinds = [mujoco.mjtGeom(int(model.geom_type[geom])).name for geom in shapes]
        shown = " and ".join(kind.removeprefix("mjGEOM_").lower() for kind in kinds) or "nothing"
        advice = "let one sphere collide, and give others contype and conaffinity 0"
        return f"collides as {shown}; {advice}"
    radius = float(model.geom_size[shapes[0], 0])
    for unit, per_metre in UNITS.items():
        if SMALLEST <= radius / per_metre <= LARGEST:
            return f"has a radius of {radius:g}, so the scene is in {unit}; write it in metres"
    if not SMALLEST <= radius <= LARGEST:
        return f"has a radius of {1000 * radius:g} mm; a ball has 20 mm"
    if np.abs([model.geom_pos[shapes[0]], model.body_ipos[body]]).max() > OFF_CENTRE:
        return "has its sphere or its mass off its origin; put both at the body's origin"
    return None


def _is_free(model: mujoco.MjModel, body: int) -> bool:
    first = model.body_jntadr[body]
    return bool(first >= 0 and model.jnt_type[first] == mujoco.mjtJoint.mjJNT_FREE)


def _is_one_sphere(model: mujoco.MjModel, body: int) -> bool:
    kinds = model.geom_type[_shapes(model, body)].tolist()
    return kinds == [mujoco.mjtGeom.mjGEOM_SPHERE]


def _shapes(model: mujoco.MjModel, body: int) -> list[int]:
    """Return the geoms of a body that collide; all of them where none does."""
    first = int(model.body_geomadr[body])
    geoms = list(range(first, first + int(model.body_geomnum[body])))
    paired = {*model.pair_geom1.tolist(), *model.pair_geom2.tolist()}
    masks = model.geom_contype | model.geom_conaffinity
    return [geom for geom in geoms if masks[geom] or geom in paired] or geoms
