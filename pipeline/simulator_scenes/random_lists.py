"""Random lists of effects, with values in the ranges that real set-ups have.

The ranges are those of ``observed`` in the catalogue. Where it has one number or none, they are
about that number, or of a size that matters in a flight.
"""

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from rallygap.models.gap.hypotheses import Hypothesis

Effects = dict[str, dict[str, float]]

# Without drag, wind would hardly show; and lists with linear drag are about it.
NEVER_LEFT_OUT = ("gravity", "drag", "linear_drag", "table_bounce")
DIGITS = 6  # of a value, after the point


@dataclass(frozen=True)
class Range:
    """Values that a parameter may have, in its unit.

    Attributes:
        low: smallest size.
        high: largest size.
        signed: whether a value may be below zero.
    """

    low: float
    high: float
    signed: bool = False

    def value(self, random: np.random.Generator) -> float:
        """Return a value, uniform in size."""
        size = random.uniform(self.low, self.high)
        sign = random.choice([-1.0, 1.0]) if self.signed else 1.0
        return round(float(sign * size), DIGITS)


Ranges = Mapping[str, Range]

_WIND, _TILT = Range(0.1, 0.5, signed=True), Range(0.0017, 0.0175, signed=True)
# Effects that MuJoCo has attributes for, but for viscosity and friction.
BASE: Ranges = {
    "gravity.g": Range(9.78, 9.83),
    "frame_tilt.x": _TILT,
    "frame_tilt.y": _TILT,
    "buoyancy.b": Range(0.5, 1.5),
    "added_mass.c": Range(0.5, 1.5),
    "drag.cd": Range(0.40, 0.56),
    "magnus.cm": Range(0.07, 0.33),
    "wind.x": _WIND,
    "wind.y": _WIND,
    "wind.z": _WIND,
    "table_bounce.restitution": Range(0.866, 0.960),
    "table_bounce.friction": Range(0.0, 0.0),
}
LINEAR_DRAG: Ranges = {"linear_drag.k1": Range(0.02, 0.2)}
LITTLE_FRICTION: Ranges = {"table_bounce.friction": Range(0.02, 0.05)}
FRICTION: Ranges = {"table_bounce.friction": Range(0.15, 0.35)}
# Effects of flight and contact that MuJoCo has no attribute for.
WITHOUT_ATTRIBUTE: Ranges = {
    "speed_dependent_drag.c": Range(0.03, 0.06, signed=True),
    "spin_dependent_drag.c": Range(0.05, 0.1),
    "lift_saturation.kappa": Range(2.0, 5.0),
    "lift_crisis.d": Range(0.5, 1.5),
    "side_force.cy": Range(0.01, 0.05, signed=True),
    "spin_decay.c": Range(0.003, 0.006),
    "table_height.h": Range(0.001, 0.003, signed=True),
    "table_tilt.x": Range(0.001, 0.005, signed=True),
    "table_tilt.y": Range(0.001, 0.005, signed=True),
    "speed_dependent_restitution.c": Range(0.004, 0.02),
    "spin_dependent_restitution.c": Range(0.002, 0.005),
    "slip_dependent_friction.c": Range(0.004, 0.012),
    "tangential_elasticity.et": Range(0.05, 0.3),
    "net.restitution": Range(0.1, 0.3),
    "net.friction": Range(0.3, 0.6),
    "racket_bounce.restitution": Range(0.84, 0.91),
    "racket_bounce.speed_loss": Range(0.015, 0.025),
    "racket_bounce.kp": Range(1.8e-3, 2.0e-3),
}


def complete_list(random: np.random.Generator, ranges: Ranges) -> Effects:
    """Return a list with a value for each parameter."""
    effects: Effects = {}
    for identity, one in ranges.items():
        parameter = Hypothesis.from_identity(identity)
        effects.setdefault(parameter.effect, {})[parameter.parameter] = one.value(random)
    return effects


def some_effects(random: np.random.Generator, effects: Effects) -> Effects:
    """Return a list in which each effect is left out with probability 1/2, if it may be."""
    kept = {name: name in NEVER_LEFT_OUT or random.random() < 0.5 for name in effects}
    return {name: values for name, values in effects.items() if kept[name]}
