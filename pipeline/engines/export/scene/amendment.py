"""A scene of MuJoCo with a list of effects in its attributes, as far as they can state it."""

from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import NamedTuple

import mujoco
import numpy as np

from rallygap.models.ball.simulator import Simulator
from rallygap.models.engines.mujoco.ball import SHELL, has_inertia
from rallygap.models.engines.mujoco.contact import table_contact
from rallygap.models.engines.mujoco.scene import MujocoScene
from rallygap.models.gap.hypotheses import Hypothesis
from rallygap.pipeline.engines.export.scene.change import Change, Element
from rallygap.pipeline.engines.export.scene.contact import (
    TABLE,
    friction_changes,
    restitution_changes,
)
from rallygap.pipeline.engines.export.scene.flight import differs, flight_changes
from rallygap.pipeline.engines.load import scene_errors
from rallygap.pipeline.web.numbers import with_unit

# The parameters that an attribute stands for.
PARAMETERS = {
    "gravity": ("gravity.g", "frame_tilt.x", "frame_tilt.y", "buoyancy.b", "added_mass.c"),
    "wind": ("wind.x", "wind.y", "wind.z"),
    "viscosity": ("linear_drag.k1",),
    "density": ("drag.cd", "magnus.cm"),
    "fluidshape": ("drag.cd", "magnus.cm"),
    "fluidcoef": ("drag.cd", "magnus.cm", "added_mass.c"),
    "solref": ("table_bounce.restitution",),
    "friction": ("table_bounce.friction",),
}
# The friction first: it takes restitution.
CONTACT_CHANGES = {"friction": friction_changes, "restitution": restitution_changes}
REASONS = {
    "shellinertia": "the list's ball is a shell",
    "mass": "as before, which shellinertia alone may change",
}


@dataclass(frozen=True, eq=False)
class SceneFile:
    """A scene of a file, as MuJoCo's specification, which edits change.

    Attributes:
        path: of the file.
        ball: name of the ball's body; None to find it.
        spec: what the file has, with the files that it includes.
        comment: the one with which ``<mujoco>`` starts; empty without one.
    """

    path: Path
    ball: str | None
    spec: mujoco.MjSpec
    comment: str

    @classmethod
    def read(cls, name: str) -> "SceneFile":
        """Read ``scene.xml`` or ``scene.xml#body``.

        Raises:
            InputError: MuJoCo cannot read the file.
        """
        path, _, ball = name.partition("#")
        with scene_errors(path):
            spec = mujoco.MjSpec.from_file(path)
            # Written as it was read, and not as it is compiled: numbers, units and defaults stay.
            spec.compiler.savecompiled, spec.compiler.savecanonical = False, False
            return cls(Path(path), ball or None, spec, spec.comment)

    def scene(self) -> MujocoScene:
        """Compile the specification.

        Raises:
            InputError: MuJoCo cannot, or the scene has no ball.
        """
        with scene_errors(self.path):
            return MujocoScene.of(self.path.stem, self.spec.compile(), self.ball)

    def text(self, lines: Sequence[str]) -> str:
        """Return the specification as MJCF, with lines in its one comment, above that of the file.

        Raises:
            InputError: MJCF cannot have what the specification has.
        """
        kept = [f"rallygap: {line}" for line in lines] + self.comment.strip().splitlines()
        self.spec.comment = " " + "\n       ".join(map(_harmless, kept)) + "\n  "
        with scene_errors(self.path):
            return str(self.spec.to_xml())

    def written(self) -> MujocoScene:
        """Return the scene that the text is, with assets of the file's folder.

        Raises:
            InputError: MuJoCo cannot read the text.
        """
        text = self.text([])
        with scene_errors(self.path):
            spec = mujoco.MjSpec.from_string(text)
            spec.modelfiledir = str(self.path.parent)
            return MujocoScene.of(self.path.stem, spec.compile(), self.ball)


class Amendment(NamedTuple):
    """A change of a scene: the attribute, and a sentence on what it was, is and comes from."""

    attribute: str
    sentence: str


def amend(
    file: SceneFile, before: Simulator, after: Simulator, comments: Sequence[str]
) -> list[Amendment]:
    """Change a scene so that it does what a list of effects says, as far as attributes can.

    Attributes change where the list differs both from what the scene does and from what it states.

    Args:
        file: of the scene; its specification is changed.
        before: what the scene does.
        after: what it is to do.
        comments: on where changed values come from, each of which begins with its parameter.

    Raises:
        InputError: the scene cannot be amended.
    """
    amendments = []

    def write(changes: Iterable[Change]) -> MujocoScene:
        for change in changes:
            origin = _origin(change.attribute, after, comments)
            amendments.append(Amendment(change.attribute, f"{change.made(file.spec)} {origin}"))
        return file.scene()

    scene = file.scene()
    changes = flight_changes(scene, before, after)
    if TABLE in after.effects and not has_inertia(scene.model, scene.ball, SHELL):
        changes += _shell_changes(file, scene)
    scene = write(changes)
    did, does = before.effects.get(TABLE), after.effects.get(TABLE)
    if does is None or table_contact(scene.model, scene.ball, scene.frame) is None:
        return amendments
    for parameter, contact_changes in CONTACT_CHANGES.items():
        if did is None or differs(did[parameter], does[parameter]):
            scene = write(contact_changes(scene, after))
    return amendments


def _shell_changes(file: SceneFile, scene: MujocoScene) -> list[Change]:
    """Return the changes to a shell; its density is that of its surface, so it needs a mass."""
    ball = Element("geom", scene.ball.geom)
    changes = [Change.of(ball, "shellinertia", 1.0)]
    if np.isnan(ball.of(file.spec).mass):
        changes.append(Change.of(ball, "mass", scene.ball.mass))
    return changes


def _origin(attribute: str, simulator: Simulator, comments: Sequence[str]) -> str:
    """Return the comments on its parameters, or their values where there are no comments."""
    if attribute in REASONS:
        return REASONS[attribute]
    names = PARAMETERS[attribute]
    said = [comment for comment in comments if comment.partition(":")[0] in names]
    if said:
        return ". ".join(said)
    parameters = [Hypothesis.from_identity(name) for name in names]
    values = [
        f"{parameter.identity} {with_unit(parameter.value(simulator), parameter.declaration.unit)}"
        for parameter in parameters
        if parameter.listed(simulator)
    ]
    return ", ".join(values) or f"No {' or '.join(names)} in the list"


def _harmless(line: str) -> str:
    """Return a line of a comment without two hyphens in a row, which end one."""
    shown = "".join(character if character.isprintable() else " " for character in line)
    return shown.replace("--", "- -").replace("--", "- -")
