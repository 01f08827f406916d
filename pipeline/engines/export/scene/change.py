"""Attributes of a scene that get other values, in MuJoCo's specification of it."""

from dataclasses import dataclass
from typing import Any, Literal

import mujoco
import numpy as np

from rallygap.models.ball.types import Floats

ROUNDING = 1e-6  # relative, of numbers as they are written
# Fields of ``MjSpec`` that have other names than the attributes.
FIELDS = {
    "fluidshape": "fluid_ellipsoid",
    "fluidcoef": "fluid_coefs",
    "shellinertia": "typeinertia",
}
# Attributes that are words, as they are without and with the field set, and the field.
WORDS = {
    "fluidshape": ("none", "ellipsoid", 1),
    "shellinertia": ("false", "true", mujoco.mjtGeomInertia.mjINERTIA_SHELL),
}


@dataclass(frozen=True)
class Element:
    """An element of a scene: ``<option>``, or a geom or a contact pair by its index."""

    kind: Literal["option", "geom", "pair"]
    index: int = 0

    def of(self, spec: mujoco.MjSpec) -> Any:
        """Return the element of a compiled specification."""
        if self.kind == "option":
            return spec.option
        return next(item for item in getattr(spec, f"{self.kind}s") if item.id == self.index)

    def described(self, spec: mujoco.MjSpec) -> str:
        """Return what to call it in a sentence."""
        if self.kind == "option":
            return "<option>"
        item = self.of(spec)
        if self.kind == "pair":
            return f"the pair of {item.geomname1} and {item.geomname2}"
        return f"the geom {item.name or f'of the body {item.parent.name}'}"


@dataclass(frozen=True, eq=False)
class Change:
    """An attribute with other numbers.

    Attributes:
        element: that has the attribute.
        attribute: its name in MJCF.
        values: its numbers, with seven digits; 1 where the attribute is a word.
    """

    element: Element
    attribute: str
    values: Floats

    @classmethod
    def of(cls, element: Element, attribute: str, values: float | Floats) -> "Change":
        """Return the change to these numbers, rounded to seven digits."""
        rounded = [float(f"{value + 0.0:.7g}") for value in np.atleast_1d(np.round(values, 12))]
        return cls(element, attribute, np.array(rounded))

    def made(self, spec: mujoco.MjSpec) -> str:
        """Set the attribute in a specification; return what it was and is, as MJCF has it."""
        element, field = self.element.of(spec), FIELDS.get(self.attribute, self.attribute)
        place = self.element.described(spec)
        if self.attribute in WORDS:
            before, after, value = WORDS[self.attribute]
        else:
            before = _text(np.atleast_1d(getattr(element, field)))
            after = _text(self.values)
            value = self.values if len(self.values) > 1 else self.values[0]
        setattr(element, field, value)
        return f'{self.attribute} of {place} was "{before}", is "{after}".'


def numbers_of(model: mujoco.MjModel, element: Element, attribute: str) -> Floats:
    """Return the numbers of a contact's attribute, ``solref`` or ``friction``, in a model."""
    return getattr(model, f"{element.kind}_{attribute}")[element.index]


def _text(values: Floats) -> str:
    return "not set" if np.isnan(values).any() else " ".join(f"{value:.7g}" for value in values)
