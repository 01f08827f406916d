"""Pages that are generated from the code: the command line and the catalogue of effects."""

from pathlib import Path

from rallygap.models.ball import state
from rallygap.models.ball.catalogue import catalogue
from rallygap.models.ball.effect import Effect, Parameter
from rallygap.models.ball.quantities import QUANTITIES
from rallygap.pipeline.io.markdown import markdown_table

COMMANDS = "# The command line\n\nThis page is generated from the commands (`make docs`).\n\n"

EFFECTS = """# The catalogue of effects

A simulator is a list of these effects, in YAML (`models/ball/simulators/`). Each is one file in
`models/ball/effects/`; this page is generated from them (`make docs`).

Units are SI, angles in radians. `u` is the ball's velocity relative to the air, `S = r|w| / |u|`
the spin ratio, `v_n` the normal and `v_b` the contact point's velocity at an impact, `w_t` the
spin in the table's plane. A parameter that a simulator leaves out takes its neutral value, at
which the effect changes nothing; one without a neutral value must be given. Other symbols are those
of [equations and constants](ball-physics.md): `alpha` is the share of `v_b` that an impact takes,
`e` and `mu` are restitution and friction.

To add an effect: [how-to](add-an-effect.md).
"""
QUANTITIES_HEAD = """## Quantities that effects change

An effect adds to one of these quantities or scales it. Without any effect a quantity has the value
under *start*.
"""
PLACES = {
    "flight": "In flight",
    "contact": "At the table, the net and the racket",
    "sensor": "In the measurement",
}

# Name in models/ball/state.py: symbol, meaning, unit, source.
CONSTANTS = {
    "BALL_MASS": ("m", "mass of the ball", "kg", "ITTF Law 2.3"),
    "BALL_RADIUS": ("r", "radius of the ball", "m", "ITTF Law 2.3"),
    "BALL_AREA": ("A", "cross-section of the ball", "m²", "π r²"),
    "BALL_VOLUME": ("V", "volume of the ball", "m³", "4/3 π r³"),
    "AIR_DENSITY": ("ρ", "density of air", "kg/m³", "20 °C, 1013 hPa"),
    "DRAG_FACTOR": ("k_D / C_D", "factor of drag, ρ A / 2m", "1/m", "Nakashima 2010"),
    "MAGNUS_FACTOR": ("k_M / C_M", "factor of lift, ρ V / m", "1", "Nakashima 2010"),
    "TABLE_HALF_LENGTH": ("", "half of the table's length, along y", "m", "ITTF Law 2.1"),
    "TABLE_HALF_WIDTH": ("", "half of the table's width, along x", "m", "ITTF Law 2.1"),
    "NET_HEIGHT": ("", "height of the net", "m", "ITTF Law 2.2"),
    "NET_OVERHANG": ("", "length of the net beyond each side line", "m", "ITTF Law 2.2"),
}


def command_page(_: Path) -> str:
    """Return the commands of ``rallygap`` with their arguments and options."""
    # Typer has no public function for what `typer ... utils docs` prints.
    from typer import Context
    from typer.cli import get_docs_for_click
    from typer.main import get_group

    from rallygap.pipeline.cli import app

    command = get_group(app)
    for subcommand in command.commands.values():
        subcommand.short_help = (subcommand.help or "").partition("\n")[
            0
        ]  # else the list has half sentences
    text = get_docs_for_click(obj=command, ctx=Context(command), name="rallygap")
    return COMMANDS + text.replace("# `rallygap`\n", "", 1)


def catalogue_page(_: Path) -> str:
    """Return the effects by place, the quantities that they change, and the constants."""
    head = ["effect", "what happens", "exact form", "parameter", "neutral", "bounds", "observed"]
    parts = [EFFECTS]
    for place, title in PLACES.items():
        effects = (effect for effect in catalogue().values() if effect.acts == place)
        rows = [_effect_row(effect, param) for effect in effects for param in effect.parameters]
        parts.append(f"## {title}\n\n{markdown_table([*head, 'source'], rows)}\n")
    parts += [
        f"{QUANTITIES_HEAD}\n{_quantities_table()}\n",
        f"## Constants\n\n{_constants_table()}",
    ]
    return "\n".join(parts)


def _effect_row(effect: Effect, parameter: Parameter) -> list[str]:
    low, high = parameter.bounds
    unit = "" if parameter.unit == "1" else f" ({parameter.unit})"
    return [
        f"`{effect.name}`",
        effect.title,
        f"`{effect.equation}`",
        f"`{parameter.name}`{unit}",
        "must be given" if parameter.required else f"{parameter.neutral:g}",
        f"{low:g} to {high:g}",
        parameter.observed,
        parameter.source,
    ]


def _constants_table() -> str:
    """Return the constants of the ball and the table."""
    rows = [
        [f"`{name}`", symbol, meaning, f"{getattr(state, name):.6g}", unit, source]
        for name, (symbol, meaning, unit, source) in CONSTANTS.items()
    ]
    return markdown_table(["name", "symbol", "meaning", "value", "unit", "source"], rows)


def _quantities_table() -> str:
    """Return the quantities that effects change."""
    rows = [
        [f"`{one.name}`", one.acts, one.meaning, f"{one.start:g}", one.size] for one in QUANTITIES
    ]
    return markdown_table(["quantity", "acts in", "meaning", "start", "components"], rows)
