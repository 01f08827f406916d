"""The contact of ball and table in a scene: what MuJoCo's attributes mean for a bounce.

MuJoCo's contact is a spring and a damper that act while they push (documentation, "Solver
parameters"): x'' = -b x' - k x for the depth x, the mass of the ball divided out. Where the
impedance ``solimp`` is constant, k and b are ``solref = "-k -b"``, or 1 / (T D)^2 and 2 / T for
``solref = "T D"``. The force ends when it would pull (Schwager and Pöschel 2007).
"""

import math
from dataclasses import dataclass

import mujoco
import numpy as np

from rallygap.models.ball.state import STATE_SIZE
from rallygap.models.ball.types import Floats
from rallygap.models.engines.mujoco.ball import Ball
from rallygap.models.engines.mujoco.frame import TableFrame
from rallygap.models.engines.mujoco.simulation import collected_warnings, initial_data

DEFAULT_SOLREF = (0.02, 1.0)
OVERLAP = 1e-4  # m, of the ball with the table when the contact is looked at
PLACE = 0.5  # of the table's half length: the ball is put there, away from the net


@dataclass(frozen=True)
class Contact:
    """The contact of ball and table.

    Attributes:
        stiffness: k, 1/s^2, above zero.
        damping: b along the normal, 1/s.
        slip_damping: b along the surface, 1/s: how fast slip ends, as far as friction allows.
        friction: coefficients along the two directions of the surface; 0 where there is none.
        torsional: whether friction also acts against spin about the normal, or against rolling.
        elliptic: whether the friction cone is a cone; otherwise a pyramid.
        lift: m, height above the surface at which the contact begins.
        default: whether ``solref`` is MuJoCo's default.
        mixed: whether the signs of ``solref`` differ, so that MuJoCo takes its default.
        raised: whether MuJoCo raises the time constant in ``solref`` to two time steps.
    """

    stiffness: float
    damping: float
    slip_damping: float
    friction: tuple[float, float]
    torsional: bool
    elliptic: bool
    lift: float
    default: bool
    mixed: bool
    raised: bool

    @property
    def damping_ratio(self) -> float:
        """Of the spring and the damper."""
        return self.damping / (2.0 * math.sqrt(self.stiffness))

    @property
    def restitution(self) -> float:
        """Of a bounce in many time steps."""
        return restitution(self.damping_ratio)

    @property
    def duration(self) -> float:
        """Of a bounce, s."""
        return _phase(self.damping_ratio) / math.sqrt(self.stiffness)

    @property
    def grip(self) -> float:
        """Share of the slip that a bounce ends, where the coefficient of friction allows it."""
        return 1.0 - math.exp(-self.slip_damping * self.duration)

    def depth(self, speed: float) -> float:
        """Return how deep a ball sinks in (m) that comes at a normal speed (m/s)."""
        return speed * math.sqrt(self.restitution / self.stiffness)


def restitution(damping_ratio: float) -> float:
    """Return the coefficient of restitution of a spring and a damper that only push."""
    return math.exp(-damping_ratio * _phase(damping_ratio))


def _phase(damping_ratio: float) -> float:
    """Return the duration of a bounce, times the root of the stiffness."""
    squared = 1.0 - damping_ratio**2
    if abs(squared) < 1e-9:  # the limit of both formulas
        return 2.0
    if squared > 0.0:
        return 2.0 * math.acos(damping_ratio) / math.sqrt(squared)
    return 2.0 * math.acosh(damping_ratio) / math.sqrt(-squared)


def table_contact(model: mujoco.MjModel, ball: Ball, frame: TableFrame) -> Contact | None:
    """Return the contact of ball and table, as MuJoCo makes it of both geoms, or of their pair.

    Returns:
        None if there is no table, or if nothing pushes the ball off it: contacts are disabled, or
        the contact has no spring.
    """
    if not frame.found:
        return None
    state = np.zeros(STATE_SIZE)
    state[:3] = 0.0, -PLACE * frame.length / 2.0, ball.radius - OVERLAP
    data = initial_data(model)
    data.qpos[ball.position : ball.position + 3] = frame.to_world(state)[:3]
    with collected_warnings():  # of a mixed solref, which is noted
        mujoco.mj_fwdPosition(model, data)
    for touch in data.contact[: data.ncon]:
        if ball.geom in touch.geom and set(touch.geom.tolist()) & set(frame.geoms):
            contact = _contact(model, touch)
            return contact if contact.stiffness > 0.0 else None
    return None


def _contact(model: mujoco.MjModel, touch: mujoco.MjContact) -> Contact:
    stiffness, damping = _spring(model, touch.solref)
    elliptic = model.opt.cone == mujoco.mjtCone.mjCONE_ELLIPTIC
    own = elliptic and touch.solreffriction.any()  # MuJoCo's rule
    slip_damping = _spring(model, touch.solreffriction)[1] if own else damping
    friction = touch.friction[:2] if touch.dim > 1 else np.zeros(2)
    return Contact(
        stiffness=stiffness,
        damping=damping,
        slip_damping=slip_damping,
        friction=(float(friction[0]), float(friction[1])),
        torsional=touch.dim > 3,
        elliptic=bool(elliptic),
        lift=float(touch.includemargin),
        default=tuple(touch.solref.tolist()) == DEFAULT_SOLREF,
        mixed=_is_mixed(touch.solref),
        raised=_raised(model, touch.solref),
    )


def _is_mixed(solref: Floats) -> bool:
    return bool((solref[0] > 0.0) != (solref[1] > 0.0))


def _raised(model: mujoco.MjModel, solref: Floats) -> bool:
    free = model.opt.disableflags & mujoco.mjtDisableBit.mjDSBL_REFSAFE
    return not free and bool(0.0 < solref[0] < 2.0 * model.opt.timestep)


def _spring(model: mujoco.MjModel, solref: Floats) -> tuple[float, float]:
    """Return stiffness and damping of a ``solref``."""
    first, second = DEFAULT_SOLREF if _is_mixed(solref) else (float(solref[0]), float(solref[1]))
    if first <= 0.0:
        return -first, -second
    constant = 2.0 * model.opt.timestep if _raised(model, np.array([first, second])) else first
    return 1.0 / (constant * second) ** 2, 2.0 / constant
