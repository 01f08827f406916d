"""Round trips: a list of effects is written into a scene of MuJoCo, and an audit finds it again.

Gravity, buoyancy and added mass act alike, and added mass also divides the forces of the air. So
a list is compared by what MuJoCo can tell apart: its fall as ``gravity.g``, and drag, lift and
linear drag after that division.
"""

from collections.abc import Mapping
from dataclasses import dataclass
from math import inf
from typing import Any

from rallygap.models.audit.audit import NOT_SEPARABLE
from rallygap.pipeline.engines.audited import audited
from rallygap.pipeline.simulator_scenes.plain_scene import Kind
from rallygap.pipeline.simulator_scenes.random_lists import Effects

Values = dict[str, float]  # by parameter

DIGITS = 5  # of a relative difference, after the point
SMALLEST = 1e-4  # of a parameter that an audit finds and a list does not have, in its unit
# Fields of ``Target``, and the parameters as which an audit finds them.
FOUND_AS = {
    "fall": "gravity.g",
    "tilt_x": "frame_tilt.x",
    "tilt_y": "frame_tilt.y",
    "wind_x": "wind.x",
    "wind_y": "wind.y",
    "wind_z": "wind.z",
    "drag": "drag.cd",
    "lift": "magnus.cm",
    "linear": "linear_drag.k1",
}


@dataclass(frozen=True)
class RoundTrip:
    """Values of a list before and after.

    Attributes:
        wanted: those of the list, as an audit can find them.
        found: those that the audit finds.
    """

    wanted: Values
    found: Values

    @property
    def differences(self) -> Values:
        """Relative differences of the parameters that the list has."""
        return {
            name: round(abs(self.found.get(name, 0.0) / value - 1.0), DIGITS)
            for name, value in self.wanted.items()
            if value
        }

    @property
    def added(self) -> Values:
        """Values of parameters that the audit finds and the list does not have."""
        return {
            name: value
            for name, value in self.found.items()
            if not self.wanted.get(name) and abs(value) > SMALLEST
        }


def round_trip(kind: Kind, effects: Effects) -> RoundTrip:
    """Write a list into the scene of a kind and audit the scene, with all probes.

    Raises:
        InputError: the scene cannot be patched or flown.
    """
    found = audited(kind.written(effects).scene, patience=inf).simulator
    return RoundTrip(as_found(effects), as_found(found.effects))


def as_found(effects: Mapping[str, Mapping[str, Any]]) -> Values:
    """Return the values of a list as an audit can find them."""
    from rallygap.pipeline.engines.export.scene.target import Target

    target = Target.of(effects)
    values = {
        f"{effect}.{name}": float(value)
        for effect, given in effects.items()
        for name, value in given.items()
    }
    values |= {name: getattr(target, one) for one, name in FOUND_AS.items()}
    return {name: value for name, value in values.items() if name not in NOT_SEPARABLE}
