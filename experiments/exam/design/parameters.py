"""Which parameters of the catalogue the exam hides, and which of them are similar."""

from collections.abc import Iterator, Sequence
from itertools import cycle

import numpy as np

from rallygap.models.ball.catalogue import catalogue
from rallygap.models.gap.hypotheses import Hypothesis

# Effects that no shot of this exam can show, and why.
NOT_OBSERVABLE = {
    "time_offset": "a constant delay only moves the instant from which a shot is counted",
    "racket_bounce": "shots are recorded from after one racket to before the next",
    "net": "every shot clears the net",
    "camera_distortion": "it is no single number; a group of questions of its own has it",
}

# Effects that may be similar; the two causes of a pair come from different families. An effect that
# is not listed here is a family of its own.
FAMILIES = (
    ("gravity", "buoyancy", "added_mass", "clock_rate", "position_scale"),
    ("drag", "linear_drag", "speed_dependent_drag", "speed_dependent_latency"),
    ("magnus", "lift_saturation", "lift_crisis", "spin_gain", "spin_decay"),
    ("wind", "frame_tilt", "side_force", "spin_axis_bias"),
    ("restitution", "speed_dependent_restitution", "spin_dependent_restitution", "table_tilt"),
    ("friction", "slip_dependent_friction", "tangential_elasticity"),
)

# Parameters that are only increased: decreased, balls would leave the table no slower than they
# meet it at the speeds of this exam, and restitution is limited to one.
ONLY_INCREASED = (Hypothesis("speed_dependent_restitution", "c"),)

# Effects of the spin labels themselves.
NEED_LABELS = ("spin_gain", "spin_axis_bias", "spin_sign_flip")


def hideable() -> list[Hypothesis]:
    """Return every parameter of the catalogue that shots can show."""
    return [
        Hypothesis(effect.name, parameter.name)
        for effect in catalogue().values()
        for parameter in effect.parameters
        if effect.name not in NOT_OBSERVABLE
    ]


def family(parameter: Hypothesis) -> str:
    """Return the first member of the family of a parameter's effect."""
    name = parameter.parameter if parameter.effect == "table_bounce" else parameter.effect
    return next((members[0] for members in FAMILIES if name in members), name)


def in_turn(parameters: Sequence[Hypothesis], random: np.random.Generator) -> Iterator[Hypothesis]:
    """Yield every parameter equally often, in a random order, without end."""
    order = random.permutation(len(parameters))
    return (parameters[place] for place in cycle(order))
