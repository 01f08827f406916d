"""The quantities that effects change, and the arguments of their hooks.

Every quantity starts at a value at which it changes nothing. Restitutions start at -1: such a
surface lets the ball through unchanged.
"""

from dataclasses import dataclass
from typing import Literal, NamedTuple

from rallygap.models.ball.types import Floats, Vector

# Of a typical ball: effects that change a coefficient leave it unchanged there.
TYPICAL_SPIN_RATIO = 0.5
TYPICAL_IMPACT = 2.5  # normal speed, m/s


class Air(NamedTuple):
    """The ball relative to the air around it."""

    velocity: Vector  # relative to the air, m/s
    spin: Vector  # rad/s
    speed: float  # length of velocity, m/s
    spin_ratio: float  # surface speed over speed, r|w| / |u|; 0 where the ball stands still


class Impact(NamedTuple):
    """A contact with the table, the net or the racket, in the surface's frame."""

    normal_speed: float  # speed at which the ball comes in along the normal, m/s, positive
    slip: float  # speed of the ball's contact point along the surface, m/s
    tangential_spin: float  # surface speed r|w_t| of the spin in the surface's plane, m/s


class View(NamedTuple):
    """The true ball at a measurement (arrays of any shape)."""

    speed: float | Floats  # m/s
    place: Floats | None = None  # (..., 3) m, where a quantity depends on it


@dataclass(frozen=True)
class Quantity:
    """One quantity of the model."""

    name: str  # identifier for hooks
    acts: Literal["flight", "contact", "sensor"]  # where it acts
    # type of the first argument of its hooks; None for a property of the environment, whose hooks
    # take only their parameters and are evaluated once per roll-out
    context: type | None
    meaning: str  # with unit
    start: float = 0.0  # its value without any effect, in every component
    size: int = 1  # number of components


QUANTITIES = (
    Quantity("wind", "flight", None, "velocity of the air, m/s", size=3),
    Quantity("gravity", "flight", None, "acceleration of free fall, m/s^2"),
    Quantity("gravity_tilt", "flight", None, "horizontal part of gravity's direction", size=2),
    Quantity("drag_coefficient", "flight", Air, "C_D"),
    Quantity("magnus_coefficient", "flight", Air, "C_M"),
    Quantity("specific_force", "flight", Air, "any other force over mass, m/s^2", size=3),
    Quantity("inertia", "flight", Air, "accelerated mass over the ball's mass", start=1.0),
    Quantity("spin_damping", "flight", Air, "relative loss of spin per metre, 1/m"),
    Quantity("table_restitution", "contact", Impact, "e of the table", start=-1.0),
    Quantity("table_friction", "contact", Impact, "mu of the table"),
    Quantity("table_elasticity", "contact", Impact, "e_t, tangential restitution of the table"),
    Quantity("table_height", "contact", None, "height of the surface over z = 0, m"),
    Quantity("table_tilt", "contact", None, "slope (x, y) of the surface's normal", size=2),
    Quantity("net_restitution", "contact", Impact, "e of the net", start=-1.0),
    Quantity("net_friction", "contact", Impact, "mu of the net"),
    Quantity("racket_restitution", "contact", Impact, "e of the racket", start=-1.0),
    Quantity(
        "racket_grip", "contact", Impact, "alpha, change of velocity over the slip, at the racket"
    ),
    Quantity("position_gain", "sensor", View, "measured over true position", start=1.0),
    Quantity("position_error", "sensor", View, "added to measured positions, m", size=3),
    Quantity("clock_gain", "sensor", View, "measured over true time", start=1.0),
    Quantity("delay", "sensor", View, "age of a measured position, s"),
    Quantity("spin_label_gain", "sensor", View, "measured over true spin", start=1.0),
    Quantity("spin_label_rotation", "sensor", View, "rotation vector of spin labels, rad", size=3),
    Quantity("spin_flip_share", "sensor", View, "share of shots with a negated spin label"),
)
