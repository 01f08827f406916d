"""Pages that are generated from the code: the command line and the catalogue of effects."""

from pathlib import Path

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


def command_page(_: Path) -> str:
    """Return the commands of ``rallygap`` with their arguments and options."""
    # Typer has no public function for what `typer ... utils docs` prints.
    from typer import Context
    from typer.cli import get_docs_for_click
    from typer.main import get_group

    from rallygap.pipeline.cli import app

    command = get_group(app)
    for subcommand in command.commands.values():
        # Else the list has half sentences.
        subcommand.short_help = (subcommand.help or "").partition("\n")[0]
    text = get_docs_for_click(obj=command, ctx=Context(command), name="rallygap")
    return COMMANDS + text.replace("# `rallygap`\n", "", 1)


def catalogue_page(_: Path) -> str:
    """Return the effects by place, and the quantities that they change."""
    head = ["effect", "what happens", "exact form", "parameter", "neutral", "bounds", "observed"]
    parts = [EFFECTS]
    for place, title in PLACES.items():
        effects = (effect for effect in catalogue().values() if effect.acts == place)
        rows = [_effect_row(effect, param) for effect in effects for param in effect.parameters]
        parts.append(f"## {title}\n\n{markdown_table([*head, 'source'], rows)}\n")
    rows = [
        [f"`{entry.name}`", entry.acts, entry.meaning, f"{entry.start:g}", str(entry.size)]
        for entry in QUANTITIES
    ]
    names = ["quantity", "acts in", "meaning", "start", "components"]
    return "\n".join([*parts, f"{QUANTITIES_HEAD}\n{markdown_table(names, rows)}"])


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
