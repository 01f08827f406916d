"""What a scene says: the list of effects that it stands for, and what one may not expect of it."""

from collections.abc import Iterator
from dataclasses import dataclass

from rallygap.models.ball.catalogue import catalogue
from rallygap.models.engines.mujoco.contact import table_contact
from rallygap.models.engines.mujoco.flight_notes import flight_notes
from rallygap.models.engines.mujoco.flight_says import flight_effects
from rallygap.models.engines.mujoco.notes import Effects, Note, NoteKind
from rallygap.models.engines.mujoco.scene import MujocoScene
from rallygap.models.engines.mujoco.table_says import table_effects, table_notes


@dataclass(frozen=True)
class Says:
    """What a scene says.

    Attributes:
        effects: the scene as a list of effects, in the table frame. Values may be outside of what
            a simulator accepts; a note says so.
        notes: what the list does not tell, or what one may not expect.
    """

    effects: Effects
    notes: tuple[Note, ...]


def says(scene: MujocoScene) -> Says:
    """Read the attributes of a scene, without flying it."""
    model, ball, frame = scene.model, scene.ball, scene.frame
    contact = table_contact(model, ball, frame)
    effects = flight_effects(model, ball, frame) | table_effects(ball, contact)
    notes = (
        *flight_notes(model, ball, frame),
        *table_notes(model, frame, contact),
        *_range_notes(effects),
    )
    return Says(effects, notes)


def _range_notes(effects: Effects) -> Iterator[Note]:
    for effect, values in effects.items():
        for parameter in catalogue()[effect].parameters:
            value, (low, high) = values[parameter.name], parameter.bounds
            if not low <= value <= high:
                problem = f"is {value:.4g}; a simulator takes {low:g} to {high:g}"
                yield Note(NoteKind.OUT_OF_RANGE, f"{effect}.{parameter.name} {problem}")
