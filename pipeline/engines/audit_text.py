"""An audit in sentences and tables, for the terminal, the page and ``audit.json``."""

from typing import Any

import numpy as np

from rallygap.models.audit.audit import Audit, FoundEffect
from rallygap.models.audit.bounces import Bounces
from rallygap.models.audit.traps import Trap
from rallygap.models.ball.catalogue import catalogue
from rallygap.pipeline.web.numbers import number, with_unit

SMALLEST = 0.01  # mm that sentences tell apart from zero
AFTER = {"flight": "after 0.4 s of flight", "table": "0.15 s after a bounce begins"}


def outcome(name: str, audit: Audit, traps: tuple[Trap, ...]) -> list[str]:
    """Return what the audit says: traps, effects, and what they do not explain."""
    effects = ", ".join(
        f"{effect.hypothesis.identity} {_value(effect)}" for effect in audit.effects
    )
    return [
        *(f"Trap: {with_cost(trap.sentence, trap.cost_mm)}" for trap in traps),
        f"{name} has {len(audit.effects)} parameters: {effects}.",
        *(
            f"Not explained by any effect {AFTER[phase]}: {_mm(left.median_mm)} in the median, "
            f"{_mm(left.largest_mm)} at most."
            for phase, left in audit.unexplained.items()
        ),
    ]


def with_cost(text: str, cost_mm: float | None) -> str:
    """Return the sentence of a trap with its cost, if it has one."""
    return text if cost_mm is None else f"{text} After 0.4 s the ball is {cost_mm:.0f} mm off."


def effects_table(audit: Audit) -> dict[str, list[str]]:
    """Return the columns of the table of effects."""
    effects = audit.effects
    worth = [effect.worth_mm for effect in effects]
    return {
        "parameter": [effect.hypothesis.identity for effect in effects],
        "effect": [catalogue()[effect.hypothesis.effect].title for effect in effects],
        "value ": [_value(effect) for effect in effects],
        "worth (mm) ": ["–" if np.isnan(size) else f"{size:.3g}" for size in worth],
        "measured balls": [effect.hypothesis.declaration.observed or "–" for effect in effects],
    }


def audit_content(name: str, audit: Audit, traps: tuple[Trap, ...]) -> dict[str, Any]:
    """Return the content of ``audit.json``."""
    return {
        "engine": name,
        "probes": audit.probes,
        "traps": [
            {
                "identifier": trap.identifier,
                "sentence": trap.sentence,
                "cost_mm": _round(trap.cost_mm),
            }
            for trap in traps
        ],
        "effects": [
            {
                "identity": effect.hypothesis.identity,
                "value": float(number(effect.value)),
                "unit": effect.hypothesis.declaration.unit,
                "worth_mm": _round(effect.worth_mm),
                "measured_balls": effect.hypothesis.declaration.observed,
            }
            for effect in audit.effects
        ],
        "unexplained": {
            phase: {"median_mm": _round(left.median_mm), "largest_mm": _round(left.largest_mm)}
            for phase, left in audit.unexplained.items()
        },
        "bounces": None if audit.bounces is None else _bounces(audit.bounces),
    }


def _bounces(bounces: Bounces) -> dict[str, float | None]:
    return {
        "share": _round(bounces.bounced.mean()),
        "restitution_lowest": _round(np.nanmin(bounces.restitution)),
        "restitution_highest": _round(np.nanmax(bounces.restitution)),
        "restitution_scatter": _round(bounces.restitution_scatter),
        "largest_grip": _round(np.nanmax(bounces.grip)),
    }


def _value(effect: FoundEffect) -> str:
    return with_unit(effect.value, effect.hypothesis.declaration.unit)


def _mm(distance: float) -> str:
    return f"{number(distance)} mm" if distance >= SMALLEST else f"less than {SMALLEST} mm"


def _round(value: float | None) -> float | None:
    return None if value is None or np.isnan(value) else float(f"{value:.4g}")
