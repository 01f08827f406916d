"""From the catalogue to compiled functions: one function a quantity, all effects inside.

Every effect takes part in every call, absent ones at their neutral value, so that any combination
of effects runs on one compilation. Numba stores what it compiled in a folder named after the
content of everything that goes into it, so a changed equation can never meet a stale binary.
"""

import getpass
import hashlib
import inspect
import os
import tempfile
from collections.abc import Callable
from functools import cache
from pathlib import Path
from typing import Any, TypeVar, cast

import numba
import platformdirs
from numba.core import config

from models.ball.catalogue import catalogue, parameter_columns
from models.ball.effect import Effect
from models.ball.quantities import QUANTITIES, Quantity

Compiled = TypeVar("Compiled", bound=Callable[..., Any])


@cache
def composed() -> dict[str, Any]:
    """Return a compiled ``function(context, parameters)`` for each quantity but the sensor's."""
    namespace: dict[str, Any] = {"njit": numba.njit(error_model="numpy")}
    for effect in catalogue().values():
        for number, change in enumerate(effect.changes):
            namespace[f"{effect.name}_{number}"] = numba.njit(error_model="numpy")(change.function)
    compiled_quantities = [quantity for quantity in QUANTITIES if quantity.acts != "sensor"]
    for quantity in compiled_quantities:
        exec(_source(quantity), namespace)
    return {quantity.name: namespace[quantity.name] for quantity in compiled_quantities}


def _source(quantity: Quantity) -> str:
    """Write the function of one quantity: its start, plus all that adds, times all that scales."""
    arguments = "p" if quantity.context is None else "context, p"
    lines = ["@njit", f"def {quantity.name}({arguments}):"]
    lines += [f"    q{i} = {quantity.start}" for i in range(quantity.size)]
    for how, operator in (("adds", "+="), ("scales", "*=")):
        for effect in catalogue().values():
            for number, change in enumerate(effect.changes):
                if change.quantity == quantity.name and change.how == how:
                    lines += _apply(quantity, f"{effect.name}_{number}", effect, operator)
    values = [f"q{i}" for i in range(quantity.size)]
    lines.append(f"    return {values[0] if quantity.size == 1 else '(' + ', '.join(values) + ')'}")
    return "\n".join(lines)


def _apply(quantity: Quantity, hook: str, effect: Effect, operator: str) -> list[str]:
    columns = [parameter_columns()[effect.name, p.name] for p in effect.parameters]
    arguments = [] if quantity.context is None else ["context"]
    arguments += [f"p[{column}]" for column in columns]
    call = f"{hook}({', '.join(arguments)})"
    if quantity.size == 1:
        return [f"    q0 {operator} {call}"]
    pieces = [f"    q{i} {operator} change[{i}]" for i in range(quantity.size)]
    return [f"    change = {call}", *pieces]


def compiled(function: Compiled) -> Compiled:
    """Decorate a function to be compiled by numba, once, and kept on disk."""
    options: Any = config  # numba fills this module at run time
    previous = options.CACHE_DIR
    options.CACHE_DIR = str(_cache_folder(Path(function.__code__.co_filename).parent))
    try:
        return cast(Compiled, numba.njit(cache=True, error_model="numpy")(function))
    finally:
        options.CACHE_DIR = previous


@cache
def _cache_folder(package: Path) -> Path:
    """Return the folder for what a package compiles, which may call all of this one."""
    digest = hashlib.sha256(numba.__version__.encode())
    for folder in (Path(__file__).parent, package):
        for path in sorted(folder.glob("*.py")):
            digest.update(path.read_bytes())
    for effect in catalogue().values():
        digest.update(repr((effect.name, [p.name for p in effect.parameters])).encode())
        for change in effect.changes:
            module = inspect.getsourcefile(change.function)
            digest.update(f"{change.quantity} {change.how}".encode())
            digest.update(Path(module).read_bytes() if module else b"")
    return _writable_cache() / digest.hexdigest()[:16]


def _writable_cache() -> Path:
    """Return the user's cache, or where the home cannot be written to a temporary one."""
    home = Path(platformdirs.user_cache_dir("rallygap"))
    return home if _own(home) else Path(tempfile.gettempdir()) / f"rallygap-{getpass.getuser()}"


def _own(folder: Path) -> bool:
    try:
        folder.mkdir(parents=True, exist_ok=True)
    except OSError:
        return False
    return os.access(folder, os.W_OK | os.X_OK)
