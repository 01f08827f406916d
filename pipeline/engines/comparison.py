"""What is compared with an audit: another engine, and what the file of a scene states."""

from dataclasses import dataclass
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
    from rallygap.models.engines.mujoco.stated import Effects

MM = 1e3
SAME = 1e-3  # relative difference of values that are alike
EXACT = "RK4"


@dataclass(frozen=True)
class Distance:
    """How far the balls of an engine are from those of an audit, medians over the probes.

    Attributes:
        name: of the engine.
        flight_mm: after 0.4 s of flight.
        bounce_mm: 0.15 s after a bounce begins.
    """

    name: str
    flight_mm: float
    bounce_mm: float

    @classmethod
    def of(cls, audit: Audit, name: str, engine: Engine) -> "Distance":
        """Fly the probes of an audit in another engine; the audit has the flights of its own."""
        sizes = []
        for flown in (audit.flown["flight"], audit.flown["table"]):
            others = engine.fly(flown.probes.states, flown.probes.times)
            away = np.linalg.norm((flown.states - others)[:, -1, POSITION], axis=-1)
            sizes.append(float(MM * np.median(away)))
        return cls(name, *sizes)

    @property
    def content(self) -> dict[str, float]:
        """Both distances, with four significant digits."""
        shown = {"flight_mm": self.flight_mm, "bounce_mm": self.bounce_mm}
        return {name: float(number(value)) for name, value in shown.items()}


@dataclass(frozen=True)
class Comparison:
    """An engine compared with another one.

    Attributes:
        audit: of the first.
        other: audit of the other.
        distance: of the other from the first.
    """

    audit: Audit
    other: Audit
    distance: Distance

    @classmethod
    def of(cls, audit: Audit, other: Engine) -> "Comparison":
        """Audit the other engine, and fly the probes of an audit in it.

        Raises:
            InputError: the other engine fails.
        """
        other_audit = cached_audit(other)
        return cls(audit, other_audit, Distance.of(audit, other.name, other))

    def sentences(self) -> list[str]:
        """Return what differs."""
        distance = self.distance
        differing = ", ".join(
            f"{name} {here} and {there}"
            for name, here, there in zip(*self.table().values(), strict=True)
        )
        return [
            f"Compared with {distance.name}, balls are {number(distance.flight_mm)} mm apart after "
            f"0.4 s of flight and {number(distance.bounce_mm)} mm after a bounce, in the median.",
            f"Parameters that differ: {differing or 'none'}.",
        ]

    def table(self) -> dict[str, list[str]]:
        """Return the columns of the parameters that differ."""
        here, there = (
            {effect.hypothesis: effect.value for effect in audit.effects}
            for audit in (self.audit, self.other)
        )
        differing = [
            parameter
            for parameter in {**here, **there}
            if _differ(here.get(parameter), there.get(parameter))
        ]
        return {
            "parameter": [parameter.identity for parameter in differing],
            "audited ": [_shown(parameter, here.get(parameter)) for parameter in differing],
            f"{self.distance.name} ": [
                _shown(parameter, there.get(parameter)) for parameter in differing
            ],
        }

    def content(self) -> dict[str, Any]:
        """Return the part of ``audit.json``."""
        effects = {
            effect.hypothesis.identity: float(number(effect.value)) for effect in self.other.effects
        }
        return {"engine": self.distance.name, "effects": effects, **self.distance.content}


@dataclass(frozen=True)
class StatedScene:
    """What the file of a scene of MuJoCo states, next to its audit.

    Attributes:
        audit: of the scene.
        effects: that its attributes stand for.
        notes: on what one may not expect of it.
        variants: distances of the scene with another integrator or time step.
    """

    audit: Audit
    effects: "Effects"
    notes: tuple[str, ...]
    variants: tuple[Distance, ...]

    @classmethod
    def of(cls, scene: "MujocoScene", audit: Audit) -> "StatedScene":
        """Read a scene that was audited, and fly its variants."""
        from rallygap.models.engines.mujoco.notes import scene_notes
        from rallygap.models.engines.mujoco.stated import stated_effects

        notes = tuple(f"{note[0].upper()}{note[1:]}." for note in scene_notes(scene))
        step = float(scene.model.opt.timestep)
        changed = {f"time step {1e3 * h:g} ms": scene.with_step(h) for h in (step / 2, step / 4)}
        changed[f"integrator {EXACT}"] = scene.with_integrator(EXACT)
        variants = tuple(Distance.of(audit, name, other) for name, other in changed.items())
        return cls(audit, stated_effects(scene), notes, variants)

    def table(self) -> dict[str, list[str]]:
        """Return the columns of what the scene states and does."""
        does = {effect.hypothesis.identity: effect.value for effect in self.audit.effects}
        states = {
            f"{effect}.{name}": value
            for effect, values in self.effects.items()
            for name, value in values.items()
        }
        shown = [name for name in {**states, **does} if states.get(name) or does.get(name)]
        units = {name: Hypothesis.from_identity(name).declaration.unit for name in shown}
        return {
            "parameter": shown,
            "the file says ": [with_unit(states.get(name, 0.0), units[name]) for name in shown],
            "the scene does ": [with_unit(does.get(name, 0.0), units[name]) for name in shown],
        }

    def variants_table(self) -> dict[str, list[str]]:
        """Return the columns of the table of variants."""
        return {
            "variant": [variant.name for variant in self.variants],
            "after 0.4 s of flight (mm) ": [number(variant.flight_mm) for variant in self.variants],
            "after a bounce (mm) ": [number(variant.bounce_mm) for variant in self.variants],
        }

    def content(self) -> dict[str, Any]:
        """Return the part of ``audit.json``."""
        return {
            "says": self.effects,
            "notes": list(self.notes),
            "variants": [{"name": variant.name, **variant.content} for variant in self.variants],
        }


def _differ(here: float | None, there: float | None) -> bool:
    if here is None or there is None:
        return True
    return abs(here - there) > SAME * max(abs(here), abs(there))


def _shown(parameter: Hypothesis, value: float | None) -> str:
    return "–" if value is None else with_unit(value, parameter.declaration.unit)
