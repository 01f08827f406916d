"""What a scene says about the table, as effects of ours and as notes."""

from collections.abc import Iterator

import mujoco

from rallygap.models.ball.state import BALL_RADIUS, TABLE_HALF_LENGTH, TABLE_HALF_WIDTH
from rallygap.models.engines.mujoco.ball import Ball
from rallygap.models.engines.mujoco.contact import Contact
from rallygap.models.engines.mujoco.flight_says import TINY
from rallygap.models.engines.mujoco.frame import TableFrame
from rallygap.models.engines.mujoco.notes import Effects, Note, NoteKind

SAME_SIZE = 0.005  # m, of the table's sides
TYPICAL_SPEED = 3.0  # m/s, normal to the table
FEWEST_STEPS = 10  # in a bounce whose restitution is right within .01 or so
DEEPEST = 1e-3  # m, to which a real ball gives way at the typical speed
FULL_GRIP = 0.9  # of the slip that a bounce ends
HASTE = 1.0  # of slip's decay over a bounce: above it, friction takes restitution while sliding


def table_effects(ball: Ball, contact: Contact | None) -> Effects:
    """Return the bounce off the table and its height; nothing without a table."""
    if contact is None:
        return {}
    bounce = {"restitution": contact.restitution, "friction": contact.friction[0]}
    height = ball.radius - BALL_RADIUS + contact.lift
    surface = {"table_height": {"h": height}} if abs(height) > TINY else {}
    return {"table_bounce": bounce, **surface}


def table_notes(
    model: mujoco.MjModel, frame: TableFrame, contact: Contact | None
) -> Iterator[Note]:
    """Yield notes on the table and on the contact with it."""
    yield from _place_notes(frame)
    if contact is not None:
        yield from _solref_notes(model, contact)
        yield from _stiffness_notes(model, contact)
        yield from _grip_notes(contact)
        yield from _cone_notes(contact)
    elif frame.found:
        yield Note(NoteKind.NO_CONTACT, "nothing pushes the ball off the table")


def _place_notes(frame: TableFrame) -> Iterator[Note]:
    if not frame.found:
        yield Note(
            NoteKind.NO_TABLE,
            "there is no table: no box of about 2.74 x 1.525 m, whole or in parts, that the ball "
            "can collide with; the world's frame is taken for the table frame",
        )
        return
    off = (frame.length - 2 * TABLE_HALF_LENGTH, frame.width - 2 * TABLE_HALF_WIDTH)
    if max(map(abs, off)) > SAME_SIZE:
        yield Note(
            NoteKind.TABLE_SIZE,
            f"the table is {frame.length:.3f} x {frame.width:.3f} m, not 2.74 x 1.525",
        )


def _solref_notes(model: mujoco.MjModel, contact: Contact) -> Iterator[Note]:
    if contact.mixed:
        yield Note(
            NoteKind.MIXED_SOLREF,
            "the numbers of solref differ in sign, so MuJoCo takes its default: restitution "
            f"{contact.restitution:.3f}",
        )
    if contact.default:
        yield Note(
            NoteKind.DEFAULT_CONTACT,
            f"solref is MuJoCo's default, so the restitution is {contact.restitution:.3f}, "
            "whatever friction and solimp say",
        )
    if contact.raised:
        yield Note(
            NoteKind.RAISED_TIME_CONSTANT,
            "the time constant in solref is shorter than two time steps, so MuJoCo raises it to "
            f"{2 * model.opt.timestep:g} s",
        )


def _stiffness_notes(model: mujoco.MjModel, contact: Contact) -> Iterator[Note]:
    steps, depth = contact.duration / model.opt.timestep, contact.depth(TYPICAL_SPEED)
    if steps < FEWEST_STEPS:
        yield Note(
            NoteKind.COARSE_CONTACT,
            f"a bounce takes {steps:.1f} time steps, so its restitution scatters about "
            f"{contact.restitution:.3f} and may exceed 1; take a step of at most "
            f"{contact.duration / FEWEST_STEPS:.2g} s or a softer contact",
        )
    if depth > DEEPEST:
        yield Note(
            NoteKind.DEEP_CONTACT,
            f"a ball at {TYPICAL_SPEED:g} m/s sinks {1000 * depth:.1f} mm into the table, is there "
            f"for {1000 * contact.duration:.1f} ms, and friction acts halfway into the overlap",
        )


def _grip_notes(contact: Contact) -> Iterator[Note]:
    if contact.friction[0] == 0.0:
        return
    if contact.grip < FULL_GRIP:
        yield Note(
            NoteKind.WEAK_GRIP,
            f"a bounce ends {100 * contact.grip:.0f} % of the slip at most, whatever the friction: "
            "slip is damped as solref says, or as the solreffriction of a pair with an elliptic "
            "cone",
        )
    if contact.elliptic and contact.slip_damping * contact.duration > HASTE:
        yield Note(
            NoteKind.STRONG_GRIP,
            "friction that ends slip this fast also takes restitution while the ball slides",
        )


def _cone_notes(contact: Contact) -> Iterator[Note]:
    if contact.friction[0] != contact.friction[1]:
        one, other = contact.friction
        yield Note(
            NoteKind.UNEQUAL_FRICTION,
            f"friction differs with direction, {one:g} and {other:g}; here it is the first",
        )
    if contact.torsional:
        yield Note(
            NoteKind.TORSIONAL_FRICTION,
            "condim above 3: friction also acts against spin about the normal, and with 6 against "
            "rolling, which no effect here expresses",
        )
    if contact.friction[0] > 0.0 and not contact.elliptic:
        yield Note(
            NoteKind.PYRAMIDAL_CONE,
            'the friction cone is a pyramid, so friction depends on direction; cone="elliptic" is '
            "round",
        )
