"""The catalogue of effects as a page of documentation, written from the effects themselves."""

from models.ball.catalogue import catalogue
from models.ball.effect import Effect, Parameter
from pipeline.io.markdown import markdown_table

PREAMBLE = """# The catalogue of effects

A simulator is a list of these effects, in YAML (`models/ball/simulators/`). Each is one file in
`models/ball/effects/`; this page is written from them by `rallygap docs`.

Units are SI, angles in radians. `u` is the ball's velocity relative to the air, `S = r|w| / |u|`
the spin ratio, `v_n` the normal and `v_b` the contact point's velocity at an impact, `w_t` the
spin in the table's plane. A parameter that a simulator leaves out takes its neutral value, at
which the effect changes nothing; one without a neutral value must be given.

To add an effect: [how-to](add-an-effect.md).
"""

HEAD = (
    *("effect", "what happens", "exact form", "parameter"),
    *("neutral", "bounds", "observed", "source"),
)
PLACES = {
    "flight": "In flight",
    "contact": "At the table, the net and the racket",
    "sensor": "In the measurement",
}


def catalogue_page() -> str:
    """Return the catalogue as Markdown: one table per place, one row per parameter."""
    parts = [PREAMBLE]
    for place, title in PLACES.items():
        rows = [
            _row(effect, parameter)
            for effect in catalogue().values()
            if effect.acts == place
            for parameter in effect.parameters
        ]
        parts.append(f"## {title}\n\n{markdown_table(HEAD, rows)}\n")
    return "\n".join(parts)


def _row(effect: Effect, parameter: Parameter) -> list[str]:
    low, high = parameter.bounds
    unit = "" if parameter.unit == "1" else f" ({parameter.unit})"
    neutral = "must be given" if parameter.required else f"{parameter.neutral:g}"
    return [
        f"`{effect.name}`",
        effect.title,
        f"`{effect.equation}`",
        f"`{parameter.name}`{unit}",
        neutral,
        f"{low:g} to {high:g}",
        parameter.observed,
        parameter.source,
    ]
