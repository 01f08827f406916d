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
# Attributes that are words, as they are without and with the field set.
WORDS = {"fluidshape": ("none", "ellipsoid"), "shellinertia": ("false", "true")}


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

    @property
    def after(self) -> str:
        """The attribute's new value as MJCF has it."""
        return WORDS[self.attribute][1] if self.attribute in WORDS else _text(self.values)

    def before(self, spec: mujoco.MjSpec) -> str:
        """Return the attribute's value in a specification as MJCF has it."""
        if self.attribute in WORDS:
            return WORDS[self.attribute][0]
        return _text(np.atleast_1d(getattr(self.element.of(spec), self._field)))

    def apply(self, model: mujoco.MjModel) -> None:
        """Set the attribute of a contact in a compiled model, without compiling it again."""
        numbers_of(model, self.element, self.attribute)[:] = self.values

    def write(self, spec: mujoco.MjSpec) -> None:
        """Set the attribute in a specification."""
        value = self.values if len(self.values) > 1 else self.values[0]
        if self.attribute in WORDS:
            value = int(value)
        if self.attribute == "shellinertia":
            value = mujoco.mjtGeomInertia.mjINERTIA_SHELL
        setattr(self.element.of(spec), self._field, value)

    @property
    def _field(self) -> str:
        return FIELDS.get(self.attribute, self.attribute)


def _text(values: Floats) -> str:
    return "not set" if np.isnan(values).any() else " ".join(f"{value:.7g}" for value in values)


def numbers_of(model: mujoco.MjModel, element: Element, attribute: str) -> Floats:
    """Return the numbers of a contact's attribute, ``solref`` or ``friction``, in a model."""
    numbers: Floats = getattr(model, f"{element.kind}_{attribute}")[element.index]
    return numbers
