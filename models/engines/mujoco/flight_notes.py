"""Notes on what a scene says about the air, the ball's body and the time step."""

from collections.abc import Iterator

import mujoco
import numpy as np

from rallygap.models.ball.state import (
    AIR_DENSITY,
    BALL_MASS,
    BALL_RADIUS,
    DRAG_FACTOR,
    MAGNUS_FACTOR,
)
from rallygap.models.engines.mujoco.air import Air, air_of, has_air, is_sphere, shaped_geoms
from rallygap.models.engines.mujoco.ball import Ball
from rallygap.models.engines.mujoco.flight_says import gravity
from rallygap.models.engines.mujoco.frame import TableFrame
from rallygap.models.engines.mujoco.notes import Note, NoteKind

PLAUSIBLE_DRAG = 0.7  # no ball has a larger coefficient
SHELL, SOLID = 2.0 / 3.0, 2.0 / 5.0  # moments of inertia over m r^2
SAME = 0.01  # relative, of an inertia or a mass
SAME_DENSITY = 0.005  # relative
SAME_RADIUS = 1e-4  # m
TYPICAL_SPIN = 300.0  # rad/s
TYPICAL_FLIGHT = 0.6  # s
VISIBLE_LOSS = 0.02  # of spin, 1/s
VISIBLE = 1e-4  # m, of an error of integration after a typical flight


def flight_notes(model: mujoco.MjModel, ball: Ball, frame: TableFrame) -> Iterator[Note]:
    """Yield notes on air, gravity, the ball's body and the integrator."""
    if has_air(model):
        air = air_of(model, ball)
        yield from _force_notes(model, ball, air)
        yield from _spin_notes(model, ball, air)
        yield from _shape_notes(model, ball)
    else:
        yield from _vacuum_notes(model)
    yield from _body_notes(ball)
    yield from _inertia_notes(model, ball)
    yield from _joint_notes(model, ball)
    yield from _step_notes(model, frame)


def _vacuum_notes(model: mujoco.MjModel) -> Iterator[Note]:
    yield Note(
        NoteKind.NO_AIR,
        "density and viscosity are 0, or passive forces are off: the ball flies in a vacuum, "
        "whatever fluidcoef says",
    )
    if model.opt.wind.any():
        yield Note(NoteKind.WIND_WITHOUT_AIR, "wind has no effect, because there is no air")


def _force_notes(model: mujoco.MjModel, ball: Ball, air: Air) -> Iterator[Note]:
    drag, lift = air.drag / ball.mass / DRAG_FACTOR, air.lift / ball.mass / MAGNUS_FACTOR
    if abs(model.opt.density / AIR_DENSITY - 1.0) > SAME_DENSITY:
        yield Note(
            NoteKind.AIR_DENSITY,
            f"the density of the air is {model.opt.density:g} kg/m^3; coefficients of drag and "
            f"lift are given here for {AIR_DENSITY:g}",
        )
    if not air.shaped:
        yield Note(
            NoteKind.NO_FLUIDSHAPE,
            'the ball has no fluidshape="ellipsoid", so MuJoCo takes it for a cube: C_D about '
            f"{drag:.2f}, changing with the ball's orientation, no lift, and fluidcoef is ignored",
        )
    elif drag > PLAUSIBLE_DRAG:
        yield Note(
            NoteKind.DRAG_TWICE,
            f"C_D is {drag:.2f}: the first number of fluidcoef is half of the drag coefficient",
        )
    if lift < 0.0:
        yield Note(
            NoteKind.INVERSE_LIFT,
            f"lift is inverse, C_M {lift:.3f}: the fifth number of fluidcoef is C_M + 0.5, because "
            "MuJoCo's added mass takes 0.5 away",
        )


def _spin_notes(model: mujoco.MjModel, ball: Ball, air: Air) -> Iterator[Note]:
    inertia = float(model.body_inertia[ball.body].mean())
    quadratic, viscous = air.spin_drag * TYPICAL_SPIN / inertia, air.viscous_spin_drag / inertia
    if quadratic > VISIBLE_LOSS:
        yield Note(
            NoteKind.SPIN_BRAKE,
            f"the air slows a spin of {TYPICAL_SPIN:g} rad/s by {quadratic:.2g} of it per second, "
            "in proportion to spin and not to speed: the third number of fluidcoef, or the cube",
        )
    if viscous > VISIBLE_LOSS:
        yield Note(
            NoteKind.VISCOUS_SPIN,
            f"viscosity slows spin by {viscous:.2g} of it per second; no effect here does that",
        )


def _shape_notes(model: mujoco.MjModel, ball: Ball) -> Iterator[Note]:
    odd = [geom for geom in shaped_geoms(model, ball) if not is_sphere(model, geom)]
    if odd:
        yield Note(
            NoteKind.OTHER_GEOMS,
            "the air also acts on geoms of the ball that are no spheres; they are left out here",
        )


def _body_notes(ball: Ball) -> Iterator[Note]:
    if abs(ball.mass / BALL_MASS - 1.0) > SAME:
        yield Note(
            NoteKind.BALL_MASS,
            f"the ball weighs {1000 * ball.mass:.3g} g, not {1000 * BALL_MASS:g}; coefficients of "
            "drag and lift are given here for the latter",
        )
    if abs(ball.radius - BALL_RADIUS) > SAME_RADIUS:
        yield Note(
            NoteKind.BALL_SIZE,
            f"the ball has a radius of {1000 * ball.radius:g} mm, not {1000 * BALL_RADIUS:g}; "
            "coefficients of drag and lift are given here for the latter, and slip at the table "
            "differs with the same spin",
        )


def _inertia_notes(model: mujoco.MjModel, ball: Ball) -> Iterator[Note]:
    share = model.body_inertia[ball.body] / (ball.mass * ball.radius**2)
    if np.allclose(share, SHELL, rtol=SAME):
        return
    if np.allclose(share, SOLID, rtol=SAME):
        yield Note(
            NoteKind.SOLID_INERTIA,
            "the ball is solid, as spheres are without shellinertia: at the table it takes at most "
            "2/7 of the slip instead of 2/5, and its spin changes by 5/3 of a shell's",
        )
    else:
        values = ", ".join(f"{value:.3g}" for value in share)
        yield Note(
            NoteKind.OTHER_INERTIA,
            f"the ball's moments of inertia are {values} m r^2; a shell has 2/3, a solid ball 2/5",
        )


def _joint_notes(model: mujoco.MjModel, ball: Ball) -> Iterator[Note]:
    joint, dof = int(model.body_jntadr[ball.body]), ball.velocity
    damping = float(model.dof_damping[dof])
    if damping > 0.0:
        inertia = float(model.body_inertia[ball.body].mean())
        yield Note(
            NoteKind.JOINT_DAMPING,
            f"the damping of the free joint slows the ball by {damping / ball.mass:.2g} of its "
            f"velocity and by {damping / inertia:.2g} of its spin per second, also in a vacuum",
        )
    others = (model.dof_armature[dof], model.dof_frictionloss[dof], model.jnt_stiffness[joint])
    if np.any(others):
        yield Note(
            NoteKind.JOINT_FORCES,
            "the free joint has armature, frictionloss or stiffness; no effect here expresses them",
        )


def _step_notes(model: mujoco.MjModel, frame: TableFrame) -> Iterator[Note]:
    size = float(np.linalg.norm(gravity(model, frame)))
    if size == 0.0:
        yield Note(NoteKind.NO_GRAVITY, "there is no gravity")
    error = 0.5 * size * model.opt.timestep * TYPICAL_FLIGHT
    if model.opt.integrator != mujoco.mjtIntegrator.mjINT_RK4 and error > VISIBLE:
        name = mujoco.mjtIntegrator(model.opt.integrator).name.removeprefix("mjINT_").lower()
        yield Note(
            NoteKind.INTEGRATOR,
            f"the integrator ({name}) errs by about {1000 * error:.1f} mm after "
            f'{TYPICAL_FLIGHT:g} s at this time step; integrator="RK4" does not',
        )
