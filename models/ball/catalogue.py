"""The catalogue of effects: every module of ``effects/`` and of the entry point group.

A package adds effects by the entry point group ``rallygap.effects``; each entry point is
a module with an ``effect``, like the modules of ``effects/``.
"""

from functools import cache

from rallygap.models.ball import effects
from rallygap.models.ball.effect import Effect
from rallygap.models.ball.quantities import QUANTITIES
from rallygap.models.support.discovery import discovered

ENTRY_POINT_GROUP = "rallygap.effects"


@cache
def catalogue() -> dict[str, Effect]:
    """Return every known effect by name, in a fixed order.

    Raises:
        ValueError: two effects share a name, or an effect changes a quantity that does not exist.
    """
    acts = {quantity.name: quantity.acts for quantity in QUANTITIES}
    known: dict[str, Effect] = {}
    for effect in discovered(effects, "effect", ENTRY_POINT_GROUP):
        if effect.name in known:
            raise ValueError(f"two effects are called {effect.name}")
        for change in effect.changes:
            if acts.get(change.quantity) != effect.acts:
                there = ", ".join(name for name, place in acts.items() if place == effect.acts)
                raise ValueError(
                    f"{effect.name} acts in {effect.acts} and changes {change.quantity!r}; "
                    f"quantities there: {there}"
                )
        known[effect.name] = effect
    return known


@cache
def parameter_columns() -> dict[tuple[str, str], int]:
    """Return the index of every (effect, parameter) in the vector that compiled functions take."""
    names = [(e.name, p.name) for e in catalogue().values() for p in e.parameters]
    return {name: column for column, name in enumerate(names)}
