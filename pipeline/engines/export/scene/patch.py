"""The text of a scene with a list of effects in its attributes; all else keeps its bytes."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

from rallygap.models.ball.simulator import Simulator
from rallygap.models.engines.mujoco.contact import table_contact
from rallygap.models.engines.mujoco.says import says
from rallygap.models.engines.mujoco.scene import MujocoScene
from rallygap.pipeline.engines.export.scene.bounce import (
    TABLE,
    ContactChange,
    Party,
    friction_change,
    restitution_change,
)
from rallygap.pipeline.engines.export.scene.flight import (
    ball_changes,
    is_shell,
    numbers,
    option_changes,
)
from rallygap.pipeline.engines.export.scene.origins import comment
from rallygap.pipeline.engines.export.scene.places import geom_tag, option_tag, pair_tag
from rallygap.pipeline.engines.export.scene.source import SceneSource
from rallygap.pipeline.engines.export.scene.tags import (
    Edit,
    Tag,
    comments_above,
    line_end,
    tags,
    with_attributes,
    with_edits,
)
from rallygap.pipeline.engines.export.scene.target import Target, differs
from rallygap.pipeline.runtime.errors import InputError


@dataclass(frozen=True)
class Patch:
    """A patched scene.

    Attributes:
        source: its text.
        scene: compiled.
        changes: names of the attributes that are changed or added.
    """

    source: SceneSource
    scene: MujocoScene
    changes: tuple[str, ...]


def patched(
    source: SceneSource, before: Simulator, after: Simulator, comments: Sequence[str]
) -> Patch:
    """Return a scene that does what a list of effects says, as far as attributes can say it.

    Attributes change where the list differs both from what the scene does and from what it says.

    Args:
        source: of the scene.
        before: what the scene does.
        after: what it is to do.
        comments: on where changed values come from, each of which begins with its parameter.

    Raises:
        InputError: the scene cannot be patched.
    """
    amended, changes = _with_flight(source, before, after, comments)
    for name, change_of in (("friction", friction_change), ("restitution", restitution_change)):
        if not _bounces_otherwise(name, amended.scene(), before, after):
            continue
        change = change_of(amended.scene(), after)
        if change is not None:
            amended = _with_contact(amended, change, after, comments)
            changes = (*changes, change.attribute)
    return Patch(amended, amended.scene(), changes)


def _with_flight(
    source: SceneSource, before: Simulator, after: Simulator, comments: Sequence[str]
) -> tuple[SceneSource, tuple[str, ...]]:
    scene = source.scene()
    did, does = Target.of(before.effects), Target.of(after.effects)
    target = Target.of(says(scene).effects).where_changed(did, does)
    changed = does.changed(did)
    options = option_changes(scene, target, changed)
    ball = ball_changes(scene, target, changed)
    if TABLE in after.effects and not is_shell(scene):
        ball |= _shell(source, scene)
    amended = _amended(source, options, {Party("geom", scene.ball.geom): ball}, after, comments)
    flying = amended.scene()
    left = option_changes(flying, target, changed) | ball_changes(flying, target, changed)
    if left:
        raise InputError(source.path, _elsewhere(tuple(left)))
    return amended, (*options, *ball)


def _shell(source: SceneSource, scene: MujocoScene) -> dict[str, str]:
    """Return the attributes of a shell; its density is that of its surface, so it needs a mass."""
    tag = _tag(source, list(tags(source.text)), Party("geom", scene.ball.geom))
    mass = {} if "mass" in tag.attributes else {"mass": numbers(scene.ball.mass)}
    return {"shellinertia": "true", **mass}


def _bounces_otherwise(name: str, scene: MujocoScene, before: Simulator, after: Simulator) -> bool:
    """Return whether a list changes a parameter of the contact of ball and table in a scene."""
    if TABLE not in after.effects or table_contact(scene.model, scene.ball, scene.frame) is None:
        return False
    did = before.effects.get(TABLE)
    return did is None or differs(did[name], after.effects[TABLE][name])


def _with_contact(
    source: SceneSource, change: ContactChange, after: Simulator, comments: Sequence[str]
) -> SceneSource:
    written = {one: change.written(source.scene(), one) for one in change.parties}
    values = {one: {change.attribute: value} for one, value in written.items() if value is not None}
    amended = _amended(source, {}, values, after, comments)
    if not change.holds(amended.scene()):
        raise InputError(source.path, _elsewhere([change.attribute]))
    return amended


def _amended(
    source: SceneSource,
    options: Mapping[str, str],
    parties: Mapping[Party, Mapping[str, str]],
    after: Simulator,
    comments: Sequence[str],
) -> SceneSource:
    """Return a text with attributes of ``<option>``, geoms and pairs changed."""
    text, found = source.text, list(tags(source.text))
    edits: list[Edit] = []
    if options:
        edits += _option_edits(text, found, options, after, comments)
    for party, values in parties.items():
        if values:
            tag = _tag(source, found, party)
            edits += _tag_edits(text, tag, values, after, comments)
    return source.with_text(with_edits(text, edits))


def _tag(source: SceneSource, found: Sequence[Tag], party: Party) -> Tag:
    model = source.scene().model
    place = pair_tag if party.kind == "pair" else geom_tag
    return place(found, model, party.index, str(source.path))


def _option_edits(
    text: str,
    found: Sequence[Tag],
    values: Mapping[str, str],
    after: Simulator,
    comments: Sequence[str],
) -> list[Edit]:
    tag = option_tag(found)
    if tag is not None:
        return _tag_edits(text, tag, values, after, comments)
    gap = line_end(text) + "  "
    said = [comment(name, None, value, after, comments) for name, value in values.items()]
    written = with_attributes("<option/>", values)
    lines = "".join(f"{gap}{one}" for one in [*(f"<!-- {one} -->" for one in said), written])
    place = _place_of_option(text, found)
    return [Edit(place, place, lines)]


def _place_of_option(text: str, found: Sequence[Tag]) -> int:
    """Return where a new ``<option>`` goes: first, or after what included files may have."""
    if any(tag.name == "include" for tag in found):
        return len(text[: text.rfind("</mujoco")].rstrip())
    return found[0].end


def _tag_edits(
    text: str, tag: Tag, values: Mapping[str, str], after: Simulator, comments: Sequence[str]
) -> list[Edit]:
    known = tag.attributes
    said = [
        comment(name, known.get(name), value, after, comments) for name, value in values.items()
    ]
    above = Edit(tag.start, tag.start, comments_above(text, tag.start, said))
    return [above, Edit(tag.start, tag.end, with_attributes(tag.text, values))]


def _elsewhere(names: Sequence[str]) -> str:
    return (
        f"{', '.join(names)} would be overridden, by an included file or another element; write "
        "it in this file, once"
    )
