"""The catalogue of effects: every file of ``effects/``, then what other packages offer.

A package adds its own effects by the entry point group ``rallygap.effects``; each entry point is
a module with an ``effect``, like the modules of ``effects/``.
"""

import importlib
import pkgutil
from functools import cache
from importlib.metadata import entry_points

from models.ball import effects
from models.ball.effect import Effect
from models.ball.quantities import QUANTITIES

ENTRY_POINT_GROUP = "rallygap.effects"


@cache
def catalogue() -> dict[str, Effect]:
    """Return every known effect by name, in a fixed order.

    Raises:
        ValueError: two effects share a name, or an effect changes a quantity that does not exist.
    """
    found: dict[str, Effect] = {}
    for effect in [*_shipped_effects(), *_offered_effects()]:
        if effect.name in found:
            raise ValueError(f"two effects are called {effect.name}")
        _check_quantities(effect)
        found[effect.name] = effect
    return found


@cache
def parameter_columns() -> dict[tuple[str, str], int]:
    """Return the place of every (effect, parameter) in the vector that compiled functions take."""
    names = [(e.name, p.name) for e in catalogue().values() for p in e.parameters]
    return {name: column for column, name in enumerate(names)}


def _shipped_effects() -> list[Effect]:
    names = sorted(module.name for module in pkgutil.iter_modules(effects.__path__))
    return [importlib.import_module(f"{effects.__name__}.{name}").effect for name in names]


def _offered_effects() -> list[Effect]:
    offers = sorted(entry_points(group=ENTRY_POINT_GROUP), key=lambda offer: offer.name)
    return [offer.load().effect for offer in offers]


def _check_quantities(effect: Effect) -> None:
    acts = {quantity.name: quantity.acts for quantity in QUANTITIES}
    for change in effect.changes:
        if acts.get(change.quantity) != effect.acts:
            known = ", ".join(name for name, place in acts.items() if place == effect.acts)
            raise ValueError(
                f"{effect.name} acts in {effect.acts} and changes {change.quantity!r}; "
                f"quantities there: {known}"
            )
