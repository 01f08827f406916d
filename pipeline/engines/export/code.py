"""A simulator as code: ``ball_effects.py``, with the functions that the catalogue has.

The file depends on nothing but the engine that it is for.
"""

import inspect
import textwrap
from collections.abc import Iterator, Sequence
from importlib.metadata import version
from pathlib import Path

from jinja2 import Environment, FileSystemLoader, StrictUndefined

from rallygap.models.ball.catalogue import catalogue
from rallygap.models.ball.effect import Change
from rallygap.models.ball.quantities import QUANTITIES, Air, Impact, Quantity
from rallygap.models.ball.simulator import Simulator
from rallygap.models.ball.state import (
    BALL_MASS,
    BALL_RADIUS,
    DRAG_FACTOR,
    MAGNUS_FACTOR,
    TABLE_HALF_LENGTH,
    TABLE_HALF_WIDTH,
)

CODE, SCENE = "ball_effects.py", "scene.xml"  # names of the files that are given back
ENGINES = ("python", "pybullet", "mujoco")  # that have a template
TEMPLATES = Path(__file__).parent / "templates"
# The arguments of a quantity's functions, before the parameters, by its context.
ARGUMENTS: dict[type | None, list[str]] = {None: [], Air: ["air"], Impact: ["impact"]}
PLAIN = ("DRAG_FACTOR", "MAGNUS_FACTOR")  # constants that every file has
# The quantities of flight and of the table.
CODED = {
    quantity.name: quantity
    for quantity in QUANTITIES
    if quantity.acts == "flight" or quantity.name.startswith("table_")
}


def ball_effects(simulator: Simulator, title: str, provenance: Sequence[str], engine: str) -> str:
    """Return the file for an engine.

    Args:
        simulator: whose flight and bounce it has; surfaces but the table, and the sensor, are left
            out.
        title: what it is, in a few words.
        provenance: lines on where its values come from.
        engine: one of ``ENGINES``.
    """
    environment = Environment(
        loader=FileSystemLoader(TEMPLATES),
        undefined=StrictUndefined,
        trim_blocks=True,
        lstrip_blocks=True,
        keep_trailing_newline=True,
    )
    named = _constants(simulator).items()
    return environment.get_template("ball_effects.py.jinja").render(
        title=_docstring(title),
        version=version("rallygap"),
        provenance=[_docstring(line) for line in provenance],
        mass=BALL_MASS,
        radius=BALL_RADIUS,
        drag_factor=DRAG_FACTOR,
        magnus_factor=MAGNUS_FACTOR,
        constants={name: value for name, value in named if name not in PLAIN},
        contexts="\n\n\n".join(inspect.getsource(context).strip() for context in (Air, Impact)),
        hooks="\n\n\n".join(_hook(*change) for change in _changes(simulator)),
        quantities="\n\n\n".join(_quantity(simulator, quantity) for quantity in CODED.values()),
        half_width=TABLE_HALF_WIDTH,
        half_length=TABLE_HALF_LENGTH,
        adaptor=environment.get_template(f"{engine}.jinja").render().rstrip(),
    )


def _docstring(text: str) -> str:
    """Return text of a user so that it stands in a docstring as it is, and never ends it."""
    plain = text.replace("\\", "\\\\").replace('"""', r"\"\"\"")
    return "".join(
        character if character.isprintable() else character.encode("unicode_escape").decode()
        for character in plain
    )


def _constants(simulator: Simulator) -> dict[str, float]:
    """Return the numbers that the functions of the effects name."""
    constants: dict[str, float] = {}
    for _, change in _changes(simulator):
        known = change.function.__globals__
        values = {name: known.get(name) for name in change.function.__code__.co_names}
        constants |= {
            name: value for name, value in values.items() if isinstance(value, int | float)
        }
    return dict(sorted(constants.items()))


def _changes(simulator: Simulator) -> Iterator[tuple[str, Change]]:
    for name in simulator.effects:
        for change in catalogue()[name].changes:
            if change.quantity in CODED:
                yield name, change


def _quantity(simulator: Simulator, quantity: Quantity) -> str:
    """Return the function of a quantity: its start, plus all added terms, times all factors."""
    context = ARGUMENTS[quantity.context]
    is_number = quantity.size == 1
    start = quantity.start if is_number else (quantity.start,) * quantity.size
    terms: dict[str, list[str]] = {"adds": [], "scales": []}
    for effect, change in _changes(simulator):
        if change.quantity == quantity.name:
            values = [repr(float(value)) for value in simulator.effects[effect].values()]
            call = f"{_name(effect, change)}({', '.join([*context, *values])})"
            if change.how == "scales":
                terms["scales"].append(f"    value *= {call}")
            else:
                added = f"+= {call}" if is_number else f"= total(value, {call})"
                terms["adds"].append(f"    value {added}")
    lines = [
        f"def {quantity.name}({', '.join(context)}):",
        f'    """{quantity.meaning[0].upper()}{quantity.meaning[1:]}."""',
        f"    value = {start!r}",
    ]
    return "\n".join([*lines, *terms["adds"], *terms["scales"], "    return value"])


def _name(effect: str, change: Change) -> str:
    return f"{effect}_{change.quantity}"


def _hook(effect: str, change: Change) -> str:
    """Return the source of a hook without its decorator, under the name of its effect."""
    lines = textwrap.dedent(inspect.getsource(change.function)).splitlines()
    start = next(k for k, line in enumerate(lines) if line.startswith("def "))
    own, name = f"def {change.function.__name__}(", f"def {_name(effect, change)}("
    return "\n".join([lines[start].replace(own, name), *lines[start + 1 :]])
