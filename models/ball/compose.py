"""Compilation of the catalogue: one function per quantity, with all effects.

Every effect takes part in every call, absent ones at their neutral value, so that one compilation
serves any combination of effects.
"""

import inspect
from functools import cache
from pathlib import Path
from typing import Any

import numba

from rallygap.models.ball.catalogue import catalogue, parameter_columns
from rallygap.models.ball.quantities import QUANTITIES, Quantity
from rallygap.models.support.compilation import compiler


@cache
def composed() -> dict[str, Any]:
    """Return a compiled ``function(context, parameters)`` for each quantity but the sensor's.

    It is ``function(parameters)`` for a quantity without a context.
    """
    namespace: dict[str, Any] = {"njit": numba.njit(error_model="numpy")}
    for effect in catalogue().values():
        for number, change in enumerate(effect.changes):
            namespace[f"{effect.name}_{number}"] = numba.njit(error_model="numpy")(change.function)
    compiled_quantities = [quantity for quantity in QUANTITIES if quantity.acts != "sensor"]
    for quantity in compiled_quantities:
        exec(_source(quantity), namespace)
    return {quantity.name: namespace[quantity.name] for quantity in compiled_quantities}


def _source(quantity: Quantity) -> str:
    """Write the function of one quantity: its start, plus all added terms, times all factors."""
    arguments = [] if quantity.context is None else ["context"]
    values = [f"q{i}" for i in range(quantity.size)]
    changed = ["change"] if quantity.size == 1 else [f"change[{i}]" for i in range(quantity.size)]
    pieces = list(zip(values, changed, strict=True))
    lines = ["@njit", f"def {quantity.name}({', '.join([*arguments, 'p'])}):"]
    lines += [f"    {value} = {quantity.start}" for value in values]
    for how, operator in (("adds", "+="), ("scales", "*=")):
        for effect in catalogue().values():
            columns = [parameter_columns()[effect.name, p.name] for p in effect.parameters]
            given = ", ".join([*arguments, *(f"p[{column}]" for column in columns)])
            for number, change in enumerate(effect.changes):
                if change.quantity == quantity.name and change.how == how:
                    lines.append(f"    change = {effect.name}_{number}({given})")
                    lines += [f"    {value} {operator} {piece}" for value, piece in pieces]
    lines.append(f"    return {values[0] if quantity.size == 1 else '(' + ', '.join(values) + ')'}")
    return "\n".join(lines)


def _sources() -> tuple[list[Path], str]:
    """Return the files that compiled functions depend on, and what they do not say."""
    files = sorted(Path(__file__).parent.glob("*.py"))
    changes = [
        (effect.name, change.quantity, change.how, [p.name for p in effect.parameters])
        for effect in catalogue().values()
        for change in effect.changes
    ]
    hooks = [change.function for effect in catalogue().values() for change in effect.changes]
    files += [Path(module) for hook in hooks if (module := inspect.getsourcefile(hook))]
    return files, repr(changes)


compiled = compiler(*_sources())
# For functions that one compiled function alone calls: their own compilation takes seconds.
inlined = numba.njit(error_model="numpy", inline="always")
