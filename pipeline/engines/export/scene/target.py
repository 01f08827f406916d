"""What a scene is to do in flight: the part of a list of effects that MuJoCo has attributes for."""

import math
from collections.abc import Mapping
from dataclasses import dataclass, fields, replace
from typing import Any

from rallygap.models.ball.state import MAGNUS_FACTOR

SAME = 1e-4  # relative; and of the unit of a number that is zero
Effects = Mapping[str, Mapping[str, Any]]


@dataclass(frozen=True)
class Target:
    """Numbers of flight. Added mass is in them: it divides all forces, also that of gravity.

    Attributes:
        fall: m/s^2, the size of gravity, with buoyancy.
        tilt_x: sine of the tilt of gravity.
        tilt_y: the same along y.
        wind_x: m/s.
        wind_y: m/s.
        wind_z: m/s.
        drag: C_D.
        lift: C_M.
        linear: k1, 1/s.
        spin_loss: c of ``spin_decay``, 1/m, for which there is no attribute.
    """

    fall: float
    tilt_x: float
    tilt_y: float
    wind_x: float
    wind_y: float
    wind_z: float
    drag: float
    lift: float
    linear: float
    spin_loss: float

    @classmethod
    def of(cls, effects: Effects) -> "Target":
        """Return the numbers of a list of effects."""

        def value(effect: str, parameter: str) -> float:
            return float(effects.get(effect, {}).get(parameter, 0.0))

        share = 1.0 / (1.0 + 0.5 * MAGNUS_FACTOR * value("added_mass", "c"))
        carried = 1.0 - MAGNUS_FACTOR * value("buoyancy", "b")
        return cls(
            fall=share * carried * value("gravity", "g"),
            tilt_x=math.sin(value("frame_tilt", "x")),
            tilt_y=math.sin(value("frame_tilt", "y")),
            wind_x=value("wind", "x"),
            wind_y=value("wind", "y"),
            wind_z=value("wind", "z"),
            drag=share * value("drag", "cd"),
            lift=share * value("magnus", "cm"),
            linear=share * value("linear_drag", "k1"),
            spin_loss=value("spin_decay", "c"),
        )

    def where_changed(self, before: "Target", after: "Target") -> "Target":
        """Return these numbers, those of ``after`` where they differ from those of ``before``.

        What a list does not change keeps its attribute, even if the scene does something else than
        the attribute says, because of its time step.
        """
        return replace(self, **{one: getattr(after, one) for one in after.changed(before)})

    def changed(self, before: "Target") -> tuple[str, ...]:
        """Return the names of the numbers that differ from those of ``before``."""
        names = [one.name for one in fields(self)]
        return tuple(one for one in names if differs(getattr(before, one), getattr(self, one)))


def differs(before: float, after: float) -> bool:
    """Return whether two values of a parameter differ."""
    return not math.isclose(before, after, rel_tol=SAME, abs_tol=SAME)
