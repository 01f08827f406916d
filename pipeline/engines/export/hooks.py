"""The code of effects: the functions of the catalogue, as text that depends on nothing else."""

import inspect
import textwrap
from collections.abc import Iterator
from types import ModuleType
from typing import Any

from rallygap.models.ball.catalogue import catalogue
from rallygap.models.ball.effect import Change
from rallygap.models.ball.quantities import QUANTITIES, Air, Impact, Quantity
from rallygap.models.ball.simulator import Simulator

CONTEXTS = (Air, Impact)


def hook_code(simulator: Simulator) -> str:
    """Return the functions of a simulator's effects of flight and contact, as they are written."""
    return "\n\n\n".join(
        _function(_name(effect, change), change) for effect, change in _changes(simulator)
    )


def constants(simulator: Simulator) -> dict[str, float]:
    """Return the numbers that these functions name."""
    found: dict[str, float] = {}
    for _, change in _changes(simulator):
        for name, value in _globals(change.function):
            if isinstance(value, int | float):
                found[name] = value
    return dict(sorted(found.items()))


def quantity_functions(simulator: Simulator) -> str:
    """Return a function for each quantity, which calls those of the effects that change it."""
    return "\n\n\n".join(_quantity(simulator, one) for one in quantities().values())


def context_code() -> str:
    """Return the classes that are the functions' first arguments."""
    return "\n\n\n".join(inspect.getsource(one).strip() for one in CONTEXTS)


def quantities() -> dict[str, Quantity]:
    """Return the quantities of flight and of the table by name."""
    return {
        one.name: one for one in QUANTITIES if one.acts == "flight" or one.name.startswith("table_")
    }


def _changes(simulator: Simulator) -> Iterator[tuple[str, Change]]:
    for name in simulator.effects:
        for change in catalogue()[name].changes:
            if change.quantity in quantities():
                yield name, change


def _of(simulator: Simulator, quantity: Quantity, how: str) -> Iterator[tuple[str, Change]]:
    for name, change in _changes(simulator):
        if change.quantity == quantity.name and change.how == how:
            yield name, change


def _quantity(simulator: Simulator, quantity: Quantity) -> str:
    """Return the function of a quantity: its start, plus all added terms, times all factors."""
    added = [_call(simulator, *one) for one in _of(simulator, quantity, "adds")]
    factors = [_call(simulator, *one) for one in _of(simulator, quantity, "scales")]
    start = repr(quantity.start) if quantity.size == 1 else repr((quantity.start,) * quantity.size)
    head = [
        f"def {quantity.name}({', '.join(_context(quantity))}):",
        f'    """{quantity.meaning[0].upper()}{quantity.meaning[1:]}."""',
        f"    value = {start}",
    ]
    if quantity.size == 1:
        lines = [f"    value += {call}" for call in added]
    else:
        lines = [f"    value = total(value, {call})" for call in added]
    lines += [f"    value *= {call}" for call in factors]
    return "\n".join([*head, *lines, "    return value"])


def _context(quantity: Quantity) -> list[str]:
    """Return the names of the arguments of a quantity's functions, before the parameters."""
    names: dict[type | None, list[str]] = {None: [], Air: ["air"], Impact: ["impact"]}
    return names[quantity.context]


def _call(simulator: Simulator, effect: str, change: Change) -> str:
    context = _context(quantities()[change.quantity])
    values = [repr(float(value)) for value in simulator.effects[effect].values()]
    return f"{_name(effect, change)}({', '.join([*context, *values])})"


def _name(effect: str, change: Change) -> str:
    return f"{effect}_{change.quantity}"


def _function(name: str, change: Change) -> str:
    """Return the source of a hook without its decorator, under another name."""
    lines = textwrap.dedent(inspect.getsource(change.function)).splitlines()
    start = next(k for k, line in enumerate(lines) if line.startswith("def "))
    signature = lines[start].replace(f"def {change.function.__name__}(", f"def {name}(")
    return "\n".join([signature, *lines[start + 1 :]])


def _globals(function: Any) -> Iterator[tuple[str, Any]]:
    for name in function.__code__.co_names:
        value = function.__globals__.get(name)
        if value is not None and not isinstance(value, ModuleType):
            yield name, value
