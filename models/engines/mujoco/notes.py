"""What a reader of a scene's file may not expect of it."""

from dataclasses import dataclass
from enum import StrEnum

Effects = dict[str, dict[str, float]]
"""Effect name -> parameter name -> value, as a simulator lists them."""


class NoteKind(StrEnum):
    """Kinds of notes."""

    # Air and gravity.
    NO_AIR = "no_air"
    AIR_DENSITY = "air_density"
    NO_FLUIDSHAPE = "no_fluidshape"
    DRAG_TWICE = "drag_twice"
    INVERSE_LIFT = "inverse_lift"
    SPIN_BRAKE = "spin_brake"
    VISCOUS_SPIN = "viscous_spin"
    OTHER_GEOMS = "other_geoms"
    WIND_WITHOUT_AIR = "wind_without_air"
    NO_GRAVITY = "no_gravity"
    # The ball.
    BALL_MASS = "ball_mass"
    BALL_SIZE = "ball_size"
    SOLID_INERTIA = "solid_inertia"
    OTHER_INERTIA = "other_inertia"
    JOINT_DAMPING = "joint_damping"
    JOINT_FORCES = "joint_forces"
    # Time steps.
    INTEGRATOR = "integrator"
    COARSE_CONTACT = "coarse_contact"
    RAISED_TIME_CONSTANT = "raised_time_constant"
    # The table.
    NO_TABLE = "no_table"
    TABLE_SIZE = "table_size"
    NO_CONTACT = "no_contact"
    DEFAULT_CONTACT = "default_contact"
    MIXED_SOLREF = "mixed_solref"
    DEEP_CONTACT = "deep_contact"
    WEAK_GRIP = "weak_grip"
    STRONG_GRIP = "strong_grip"
    PYRAMIDAL_CONE = "pyramidal_cone"
    UNEQUAL_FRICTION = "unequal_friction"
    TORSIONAL_FRICTION = "torsional_friction"
    # Our effects.
    OUT_OF_RANGE = "out_of_range"


@dataclass(frozen=True)
class Note:
    """One note: its kind, and a sentence that explains it with this scene's numbers."""

    kind: NoteKind
    sentence: str
