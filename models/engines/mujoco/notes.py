"""What one may not expect of a scene: sentences with its numbers."""

from collections.abc import Iterator

import mujoco
import numpy as np

from rallygap.models.ball.catalogue import catalogue
from rallygap.models.ball.state import (
    AIR_DENSITY,
    BALL_MASS,
    BALL_RADIUS,
    DRAG_FACTOR,
    MAGNUS_FACTOR,
    TABLE_HALF_LENGTH,
    TABLE_HALF_WIDTH,
)
from rallygap.models.engines.mujoco.air import air_of, has_air, is_sphere, shaped_geoms
from rallygap.models.engines.mujoco.ball import SHELL, SOLID, Ball, has_inertia
from rallygap.models.engines.mujoco.contact import Contact, table_contact
from rallygap.models.engines.mujoco.frame import TableFrame
from rallygap.models.engines.mujoco.scene import MujocoScene
from rallygap.models.engines.mujoco.stated import gravity, stated_effects

PLAUSIBLE_DRAG = 0.7  # no ball has a larger coefficient
SAME = 0.01  # relative, of a mass
SAME_DENSITY = 0.005  # relative
SAME_RADIUS = 1e-4  # m
TYPICAL_SPIN = 300.0  # rad/s
TYPICAL_FLIGHT = 0.6  # s
VISIBLE_LOSS = 0.02  # of spin, 1/s
VISIBLE = 1e-4  # m, of an error of integration after a typical flight
SAME_SIZE = 0.005  # m, of the table's sides
TYPICAL_SPEED = 3.0  # m/s, normal to the table
FEWEST_STEPS = 10  # in a bounce whose restitution is right within .01 or so
DEEPEST = 1e-3  # m, to which a real ball gives way at the typical speed
FULL_GRIP = 0.9  # of the slip that a bounce ends
HASTE = 1.0  # of slip's decay over a bounce: above it, friction takes restitution while sliding


def scene_notes(scene: MujocoScene) -> Iterator[str]:
    """Yield what the list of a scene's attributes does not tell, or what one may not expect.

    Notes begin in lower case and have no full stop.
    """
    model, ball, frame = scene.model, scene.ball, scene.frame
    yield from _air_notes(model, ball)
    yield from _ball_notes(model, ball)
    yield from _joint_notes(model, ball)
    yield from _step_notes(model, frame)
    yield from _place_notes(frame)
    contact = table_contact(model, ball, frame)
    if contact is not None:
        yield from _contact_notes(model, contact)
        yield from _friction_notes(contact)
    elif frame.found:
        yield "nothing pushes the ball off the table"
    for effect, values in stated_effects(scene).items():
        for parameter in catalogue()[effect].parameters:
            value, (low, high) = values[parameter.name], parameter.bounds
            if not low <= value <= high:
                problem = f"is {value:.4g}; a simulator takes {low:g} to {high:g}"
                yield f"{effect}.{parameter.name} {problem}"


def _air_notes(model: mujoco.MjModel, ball: Ball) -> Iterator[str]:
    if not has_air(model):
        yield (
            "density and viscosity are 0, or passive forces are off: the ball flies in a vacuum, "
            "whatever fluidcoef says"
        )
        if model.opt.wind.any():
            yield "wind has no effect, because there is no air"
        return
    air, inertia = air_of(model, ball), float(model.body_inertia[ball.body].mean())
    drag, lift = air.drag / ball.mass / DRAG_FACTOR, air.lift / ball.mass / MAGNUS_FACTOR
    quadratic, viscous = air.spin_drag * TYPICAL_SPIN / inertia, air.viscous_spin_drag / inertia
    if abs(model.opt.density / AIR_DENSITY - 1.0) > SAME_DENSITY:
        yield (
            f"the density of the air is {model.opt.density:g} kg/m^3; coefficients of drag and "
            f"lift are given here for {AIR_DENSITY:g}"
        )
    if not air.shaped:
        yield (
            'the ball has no fluidshape="ellipsoid", so MuJoCo takes it for a cube: C_D about '
            f"{drag:.2f}, changing with the ball's orientation, no lift, and fluidcoef is ignored"
        )
    elif drag > PLAUSIBLE_DRAG:
        yield f"C_D is {drag:.2f}: the first number of fluidcoef is half of the drag coefficient"
    if lift < 0.0:
        yield (
            f"lift is inverse, C_M {lift:.3f}: the fifth number of fluidcoef is C_M + 0.5, because "
            "MuJoCo's added mass takes 0.5 away"
        )
    if quadratic > VISIBLE_LOSS:
        yield (
            f"the air slows a spin of {TYPICAL_SPIN:g} rad/s by {quadratic:.2g} of it per second, "
            "in proportion to spin and not to speed: the third number of fluidcoef, or the cube"
        )
    if viscous > VISIBLE_LOSS:
        yield f"viscosity slows spin by {viscous:.2g} of it per second; no effect here does that"
    if any(not is_sphere(model, geom) for geom in shaped_geoms(model, ball)):
        yield "the air also acts on geoms of the ball that are no spheres; they are left out here"


def _ball_notes(model: mujoco.MjModel, ball: Ball) -> Iterator[str]:
    if abs(ball.mass / BALL_MASS - 1.0) > SAME:
        yield (
            f"the ball weighs {1000 * ball.mass:.3g} g, not {1000 * BALL_MASS:g}; coefficients of "
            "drag and lift are given here for the latter"
        )
    if abs(ball.radius - BALL_RADIUS) > SAME_RADIUS:
        yield (
            f"the ball has a radius of {1000 * ball.radius:g} mm, not {1000 * BALL_RADIUS:g}; "
            "coefficients of drag and lift are given here for the latter, and slip at the table "
            "differs with the same spin"
        )
    if has_inertia(model, ball, SOLID):
        yield (
            "the ball is solid, as spheres are without shellinertia: at the table it takes at most "
            "2/7 of the slip instead of 2/5, and its spin changes by 5/3 of a shell's"
        )
    elif not has_inertia(model, ball, SHELL):
        share = model.body_inertia[ball.body] / (ball.mass * ball.radius**2)
        values = ", ".join(f"{value:.3g}" for value in share)
        yield (
            f"the ball's moments of inertia are {values} m r^2; a shell has 2/3, a solid ball 2/5"
        )


def _joint_notes(model: mujoco.MjModel, ball: Ball) -> Iterator[str]:
    joint, dof = int(model.body_jntadr[ball.body]), ball.velocity
    damping = float(model.dof_damping[dof])
    if damping > 0.0:
        inertia = float(model.body_inertia[ball.body].mean())
        yield (
            f"the damping of the free joint slows the ball by {damping / ball.mass:.2g} of its "
            f"velocity and by {damping / inertia:.2g} of its spin per second, also in a vacuum"
        )
    others = (model.dof_armature[dof], model.dof_frictionloss[dof], model.jnt_stiffness[joint])
    if np.any(others):
        yield (
            "the free joint has armature, frictionloss or stiffness; no effect here expresses them"
        )


def _step_notes(model: mujoco.MjModel, frame: TableFrame) -> Iterator[str]:
    size = float(np.linalg.norm(gravity(model, frame)))
    if size == 0.0:
        yield "there is no gravity"
    error = 0.5 * size * model.opt.timestep * TYPICAL_FLIGHT
    if model.opt.integrator != mujoco.mjtIntegrator.mjINT_RK4 and error > VISIBLE:
        name = mujoco.mjtIntegrator(model.opt.integrator).name.removeprefix("mjINT_").lower()
        yield (
            f"the integrator ({name}) errs by about {1000 * error:.1f} mm after "
            f'{TYPICAL_FLIGHT:g} s at this time step; integrator="RK4" does not'
        )


def _place_notes(frame: TableFrame) -> Iterator[str]:
    if not frame.found:
        yield (
            "there is no table: no box of about 2.74 x 1.525 m, whole or in parts, that the ball "
            "can collide with; the world's frame is taken for the table frame"
        )
        return
    off = (frame.length - 2 * TABLE_HALF_LENGTH, frame.width - 2 * TABLE_HALF_WIDTH)
    if max(map(abs, off)) > SAME_SIZE:
        yield f"the table is {frame.length:.3f} x {frame.width:.3f} m, not 2.74 x 1.525"


def _contact_notes(model: mujoco.MjModel, contact: Contact) -> Iterator[str]:
    if contact.mixed:
        yield (
            "the numbers of solref differ in sign, so MuJoCo takes its default: restitution "
            f"{contact.restitution:.3f}"
        )
    if contact.default:
        yield (
            f"solref is MuJoCo's default, so the restitution is {contact.restitution:.3f}, "
            "whatever friction and solimp say"
        )
    if contact.raised:
        yield (
            "the time constant in solref is shorter than two time steps, so MuJoCo raises it to "
            f"{2 * model.opt.timestep:g} s"
        )
    steps, depth = contact.duration / model.opt.timestep, contact.depth(TYPICAL_SPEED)
    if steps < FEWEST_STEPS:
        yield (
            f"a bounce takes {steps:.1f} time steps, so its restitution scatters about "
            f"{contact.restitution:.3f} and may exceed 1; take a step of at most "
            f"{contact.duration / FEWEST_STEPS:.2g} s or a softer contact"
        )
    if depth > DEEPEST:
        yield (
            f"a ball at {TYPICAL_SPEED:g} m/s sinks {1000 * depth:.1f} mm into the table, is there "
            f"for {1000 * contact.duration:.1f} ms, and friction acts halfway into the overlap"
        )


def _friction_notes(contact: Contact) -> Iterator[str]:
    has_friction = contact.friction[0] > 0.0
    if has_friction and contact.grip < FULL_GRIP:
        yield (
            f"a bounce ends {100 * contact.grip:.0f} % of the slip at most, whatever the friction: "
            "slip is damped as solref says, or as the solreffriction of a pair with an elliptic "
            "cone"
        )
    if has_friction and contact.elliptic and contact.slip_damping * contact.duration > HASTE:
        yield "friction that ends slip this fast also takes restitution while the ball slides"
    if contact.friction[0] != contact.friction[1]:
        first, second = contact.friction
        yield f"friction differs with direction, {first:g} and {second:g}; here it is the first"
    if contact.torsional:
        yield (
            "condim above 3: friction also acts against spin about the normal, and with 6 against "
            "rolling, which no effect here expresses"
        )
    if has_friction and not contact.elliptic:
        yield (
            'the friction cone is a pyramid, so friction depends on direction; cone="elliptic" is '
            "round"
        )
