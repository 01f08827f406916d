"""Comments on changed attributes: what they were, what they are, and where that comes from."""

from collections.abc import Sequence

from rallygap.models.ball.simulator import Simulator
from rallygap.models.gap.hypotheses import Hypothesis
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
REASONS = {
    "shellinertia": "the list's ball is a shell",
    "mass": "as before, which shellinertia alone may change",
}


def comment(
    attribute: str, before: str | None, after: str, simulator: Simulator, comments: Sequence[str]
) -> str:
    """Return the comment on a changed attribute.

    Args:
        attribute: its name.
        before: as it was written; None where it was not.
        after: as it is.
        simulator: the list of effects that it comes from.
        comments: of the list, each of which begins with its parameter.
    """
    was = f'was "{before}"' if before is not None else "was not written"
    reason = REASONS.get(attribute) or _origin(attribute, simulator, comments)
    return f'rallygap: {attribute} {was}, is "{after}". {reason}'


def _origin(attribute: str, simulator: Simulator, comments: Sequence[str]) -> str:
    """Return the comments on its parameters, or their values where there are no comments."""
    names = PARAMETERS[attribute]
    said = [one for one in comments if one.partition(":")[0] in names]
    if said:
        return ". ".join(said)
    values = [Hypothesis.from_identity(name) for name in names]
    return (
        ", ".join(
            f"{one.identity} {with_unit(one.value(simulator), one.declaration.unit)}"
            for one in values
            if one.listed(simulator)
        )
        or f"No {' or '.join(names)} in the list"
    )
