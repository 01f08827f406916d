"""What is compared with an audit: another engine, and what the file of a scene states."""

import math
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any

import numpy as np

from rallygap.models.audit.audit import Audit
from rallygap.models.ball.state import POSITION
from rallygap.models.engines.engine import Engine
from rallygap.models.gap.hypotheses import Hypothesis
from rallygap.pipeline.engines.audited import cached_audit
from rallygap.pipeline.web.numbers import number, with_unit

if TYPE_CHECKING:
    from rallygap.models.engines.mujoco.scene import MujocoScene

Columns = dict[str, list[str]]

MM = 1e3
SAME = 1e-3  # relative difference of values that are alike
EXACT = "RK4"


@dataclass(frozen=True)
class Comparison:
    """What stands next to an audit; by default nothing.

    Attributes:
        sentences: on what differs, or what one may not expect.
        tables: for the page, each of columns.
        content: the part of ``audit.json``.
    """

    sentences: tuple[str, ...] = ()
    tables: dict[str, Columns] = field(default_factory=dict)
    content: dict[str, Any] = field(default_factory=dict)


def compared(audit: Audit, other: Engine) -> Comparison:
    """Audit another engine, and fly the probes of an audit in it.

    Raises:
        InputError: the other engine fails.
    """
    effects = cached_audit(other).effects
    flight, bounce = _distances(audit, other)
    here = {effect.hypothesis: effect.value for effect in audit.effects}
    there = {effect.hypothesis: effect.value for effect in effects}
    differing = [name for name in {**here, **there} if _differ(here.get(name), there.get(name))]
    table = {
        "parameter": [name.identity for name in differing],
        "audited ": [_shown(name, here.get(name)) for name in differing],
        f"{other.name} ": [_shown(name, there.get(name)) for name in differing],
    }
    rows = zip(*table.values(), strict=True)
    listed = ", ".join(f"{name} {first} and {second}" for name, first, second in rows)
    content = {
        "engine": other.name,
        "effects": {effect.hypothesis.identity: float(number(effect.value)) for effect in effects},
        "flight_mm": float(flight),
        "bounce_mm": float(bounce),
    }
    sentences = (
        f"Compared with {other.name}, balls are {flight} mm apart after 0.4 s of flight and "
        f"{bounce} mm after a bounce, in the median.",
        f"Parameters that differ: {listed or 'none'}.",
    )
    return Comparison(sentences, {"against": table}, {"against": content})


def stated(scene: "MujocoScene", audit: Audit) -> Comparison:
    """Read what the file of a scene states, note what one may not expect, and fly its variants.

    Variants are the scene with shorter time steps and with another integrator.
    """
    from rallygap.models.engines.mujoco.notes import scene_notes
    from rallygap.models.engines.mujoco.stated import stated_effects

    notes = tuple(f"{note[0].upper()}{note[1:]}." for note in scene_notes(scene))
    step = float(scene.model.opt.timestep)
    changed = {f"time step {1e3 * h:g} ms": scene.with_step(h) for h in (step / 2, step / 4)}
    changed[f"integrator {EXACT}"] = scene.with_integrator(EXACT)
    apart = {name: _distances(audit, variant) for name, variant in changed.items()}
    does = {effect.hypothesis.identity: effect.value for effect in audit.effects}
    effects = stated_effects(scene)
    says = {
        f"{effect}.{name}": value
        for effect, values in effects.items()
        for name, value in values.items()
    }
    shown = [name for name in {**says, **does} if says.get(name) or does.get(name)]
    units = {name: Hypothesis.from_identity(name).declaration.unit for name in shown}
    tables = {
        "says": {
            "parameter": shown,
            "the file says ": [with_unit(says.get(name, 0.0), units[name]) for name in shown],
            "the scene does ": [with_unit(does.get(name, 0.0), units[name]) for name in shown],
        },
        "variants": {
            "variant": list(apart),
            "after 0.4 s of flight (mm) ": [flight for flight, _ in apart.values()],
            "after a bounce (mm) ": [bounce for _, bounce in apart.values()],
        },
    }
    variants = [
        {"name": name, "flight_mm": float(flight), "bounce_mm": float(bounce)}
        for name, (flight, bounce) in apart.items()
    ]
    return Comparison(notes, tables, {"says": effects, "notes": notes, "variants": variants})


def _distances(audit: Audit, engine: Engine) -> tuple[str, str]:
    """Fly the probes of an audit, which has the flights of its own engine, in another one.

    Returns:
        mm, medians over the probes with four significant digits: after 0.4 s of flight, and 0.15 s
        after a bounce begins.
    """
    sizes = []
    for flown in (audit.flown["flight"], audit.flown["table"]):
        others = engine.fly(flown.probes.states, flown.probes.times)
        away = np.linalg.norm((flown.states - others)[:, -1, POSITION], axis=-1)
        sizes.append(number(float(MM * np.median(away))))
    return sizes[0], sizes[1]


def _differ(here: float | None, there: float | None) -> bool:
    return here is None or there is None or not math.isclose(here, there, rel_tol=SAME)


def _shown(parameter: Hypothesis, value: float | None) -> str:
    return "–" if value is None else with_unit(value, parameter.declaration.unit)
