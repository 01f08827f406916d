"""The arm as URDF, built from the constants: primitive shapes with the inertias of solids."""

from collections.abc import Sequence
from xml.etree import ElementTree as Xml

import numpy as np

from rallygap.models.ball.types import Floats
from rallygap.models.robot.constants import BASE_SOLIDS, JOINTS, Joint, Solid

COLOURS = ("0.35 0.37 0.40 1", "0.85 0.86 0.88 1", "0.85 0.10 0.12 1")  # base, links, racket


def urdf() -> str:
    """Return the arm: a fixed base, then for every joint of the constants the link it moves."""
    arm = Xml.Element("robot", name="arm")
    for colour, rgba in zip(("dark", "light", "red"), COLOURS, strict=True):
        Xml.SubElement(Xml.SubElement(arm, "material", name=colour), "color", rgba=rgba)
    _add_link(arm, "base", BASE_SOLIDS, "dark")
    parent = "base"
    for joint in JOINTS:
        _add_link(arm, f"{joint.name}_link", joint.link, "red" if joint is JOINTS[-1] else "light")
        _add_joint(arm, joint, parent)
        parent = f"{joint.name}_link"
    Xml.indent(arm)
    return Xml.tostring(arm, encoding="unicode")


def inertia(solids: Sequence[Solid]) -> tuple[float, Floats, Floats]:
    """Return mass (kg), centre of mass (3,) m and inertia (3, 3) kg m^2 about it, link axes."""
    masses = np.array([solid.mass for solid in solids])
    positions = np.array([solid.position for solid in solids], dtype=np.float64)
    centre = masses @ positions / masses.sum()
    total = np.zeros((3, 3))
    for solid, offset in zip(solids, positions - centre, strict=True):
        c, s = np.cos(solid.pitch), np.sin(solid.pitch)
        rotation = np.array([[1, 0, 0], [0, c, -s], [0, s, c]])
        central = rotation @ np.diag(_principal(solid)) @ rotation.T
        # Parallel-axis theorem.
        total += central + solid.mass * (offset @ offset * np.eye(3) - np.outer(offset, offset))
    return float(masses.sum()), centre, total


def _principal(solid: Solid) -> Floats:
    """Return the (3,) principal moments of a homogeneous box or cylinder."""
    if solid.shape == "box":
        x, y, z = np.square(solid.size)
        return solid.mass / 12 * np.array([y + z, x + z, x + y])
    radius, length = np.square(solid.size)
    level = radius / 4 + length / 12
    return solid.mass * np.array([level, level, radius / 2])


def _add_link(arm: Xml.Element, name: str, solids: Sequence[Solid], colour: str) -> None:
    link = Xml.SubElement(arm, "link", name=name)
    mass, centre, tensor = inertia(solids)
    inertial = Xml.SubElement(link, "inertial")
    Xml.SubElement(inertial, "origin", xyz=_text(*centre), rpy=_text(0, 0, 0))
    Xml.SubElement(inertial, "mass", value=_text(mass))
    upper = {f"i{'xyz'[i]}{'xyz'[j]}": _text(tensor[i, j]) for i in range(3) for j in range(i, 3)}
    Xml.SubElement(inertial, "inertia", upper)
    for solid in solids:
        sizes = {"size": _text(*solid.size)}
        if solid.shape == "cylinder":
            sizes = dict(zip(("radius", "length"), map(_text, solid.size), strict=True))
        for use in ("visual", "collision"):
            part = Xml.SubElement(link, use)
            Xml.SubElement(part, "origin", xyz=_text(*solid.position), rpy=_text(solid.pitch, 0, 0))
            Xml.SubElement(Xml.SubElement(part, "geometry"), solid.shape, sizes)
            if use == "visual":
                Xml.SubElement(part, "material", name=colour)


def _add_joint(arm: Xml.Element, joint: Joint, parent: str) -> None:
    element = Xml.SubElement(arm, "joint", name=joint.name, type=joint.kind)
    Xml.SubElement(element, "parent", link=parent)
    Xml.SubElement(element, "child", link=f"{joint.name}_link")
    Xml.SubElement(element, "origin", xyz=_text(*joint.origin), rpy=_text(joint.pitch, 0, 0))
    Xml.SubElement(element, "axis", xyz=_text(*(float(joint.axis == name) for name in "xyz")))
    limits = {"lower": joint.lower, "upper": joint.upper}
    drive = {"velocity": joint.speed, "effort": joint.force}
    Xml.SubElement(element, "limit", {k: _text(v) for k, v in (limits | drive).items()})


def _text(*numbers: float) -> str:
    return " ".join(repr(float(number)) for number in numbers)
