"""Where the attributes of a scene stand in its text: options, geoms and pairs."""

from collections.abc import Sequence

import mujoco

from rallygap.pipeline.engines.export.scene.tags import Tag
from rallygap.pipeline.runtime.errors import InputError


def option_tag(tags: Sequence[Tag]) -> Tag | None:
    """Return the last ``<option>`` of a scene, which overrides those before it."""
    options = [tag for tag in tags if tag.name == "option" and len(tag.parents) == 1]
    return options[-1] if options else None


def geom_tag(tags: Sequence[Tag], model: mujoco.MjModel, geom: int, path: str) -> Tag:
    """Return the tag of a geom, by its name or by its place in its body.

    Args:
        tags: of the scene's text.
        model: the scene.
        geom: index of the geom.
        path: of the scene, for the error.

    Raises:
        InputError: the geom is not in this text, but in an included file or made by another
            element.
    """
    geoms = [tag for tag in tags if tag.name == "geom" and tag.parent("worldbody")]
    name = model.geom(geom).name
    if name:
        found = [tag for tag in geoms if tag.attributes.get("name") == name]
    else:
        found = _by_place(tags, geoms, model, geom)
    if len(found) != 1:
        raise InputError(path, _not_here(model, geom))
    return found[0]


def pair_tag(tags: Sequence[Tag], model: mujoco.MjModel, pair: int, path: str) -> Tag:
    """Return the tag of a contact pair, by the names of its geoms.

    Raises:
        InputError: the pair is not in this text.
    """
    names = {model.geom(int(one)).name for one in (model.pair_geom1[pair], model.pair_geom2[pair])}
    for tag in tags:
        ends = {tag.attributes.get("geom1"), tag.attributes.get("geom2")}
        if tag.name == "pair" and tag.parent("contact") and ends == names:
            return tag
    problem = f"the pair of {' and '.join(sorted(names))} is not in this file; write it here"
    raise InputError(path, problem)


def _by_place(
    tags: Sequence[Tag], geoms: Sequence[Tag], model: mujoco.MjModel, geom: int
) -> list[Tag]:
    """Return the tag of a geom without a name; none where text and scene differ in number."""
    body = int(model.geom_bodyid[geom])
    owner = _body_tag(tags, model, body)
    if owner is None and body > 0:
        return []
    within = [tag for tag in geoms if tag.parent("body") == owner]
    if len(within) != model.body_geomnum[body]:
        return []
    return [within[geom - int(model.body_geomadr[body])]]


def _body_tag(tags: Sequence[Tag], model: mujoco.MjModel, body: int) -> Tag | None:
    """Return the tag of a body, by its name or, where text and scene agree, by its number."""
    bodies = [tag for tag in tags if tag.name == "body" and tag.parent("worldbody")]
    name = model.body(body).name
    if name and body > 0:
        return next((tag for tag in bodies if tag.attributes.get("name") == name), None)
    return bodies[body - 1] if body > 0 and len(bodies) == model.nbody - 1 else None


def _not_here(model: mujoco.MjModel, geom: int) -> str:
    owner = model.body(int(model.geom_bodyid[geom])).name
    shown = model.geom(geom).name or f"of the body {owner!r}"
    return (
        f"the geom {shown} is not written in this file, but in one that it includes, or another "
        "element makes it; write its body here and give the geom a name"
    )
