"""What a scene of MuJoCo says, next to what it does, and what its time step changes."""

from collections.abc import Iterator
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

from rallygap.models.audit.audit import Audit
from rallygap.models.gap.hypotheses import Hypothesis
from rallygap.pipeline.engines.comparison import Apart, distances
from rallygap.pipeline.web.numbers import number, with_unit

if TYPE_CHECKING:
    from rallygap.models.engines.mujoco.notes import Effects
    from rallygap.models.engines.mujoco.scene import MujocoScene

EXACT = "RK4"


@dataclass(frozen=True)
class Variant(Apart):
    """A scene with another integrator or time step, compared with the scene as it is.

    Attributes:
        name: what is changed.
    """

    name: str


@dataclass(frozen=True)
class SceneAudit:
    """What a scene says, and what its time step changes.

    Attributes:
        effects: that its attributes stand for.
        notes: on what one may not expect of it.
        variants: of its integrator and time step.
    """

    effects: "Effects"
    notes: tuple[str, ...]
    variants: tuple[Variant, ...]

    @classmethod
    def of(cls, scene: "MujocoScene", audit: Audit) -> "SceneAudit":
        """Read a scene that was audited, and fly its variants."""
        from rallygap.models.engines.mujoco.says import says

        said = says(scene)
        notes = tuple(f"{one.sentence[0].upper()}{one.sentence[1:]}." for one in said.notes)
        return cls(said.effects, notes, tuple(_variants(scene, audit)))

    def says_and_does(self, audit: Audit) -> dict[str, list[str]]:
        """Return the columns of the table of what the scene says and does."""
        found = {one.hypothesis.identity: one.value for one in audit.effects}
        said = {
            f"{effect}.{name}": value
            for effect, values in self.effects.items()
            for name, value in values.items()
        }
        shown = [one for one in {**said, **found} if said.get(one) or found.get(one)]
        units = [Hypothesis.from_identity(one).declaration.unit for one in shown]
        return {
            "parameter": shown,
            "the file says ": [
                with_unit(said.get(one, 0.0), unit) for one, unit in zip(shown, units, strict=True)
            ],
            "the scene does ": [
                with_unit(found.get(one, 0.0), unit) for one, unit in zip(shown, units, strict=True)
            ],
        }

    def variants_table(self) -> dict[str, list[str]]:
        """Return the columns of the table of variants."""
        return {
            "variant": [one.name for one in self.variants],
            "after 0.4 s of flight (mm) ": [number(one.flight_mm) for one in self.variants],
            "after a bounce (mm) ": [number(one.bounce_mm) for one in self.variants],
        }

    def content(self) -> dict[str, Any]:
        """Return the part of ``audit.json``."""
        return {
            "says": self.effects,
            "notes": list(self.notes),
            "variants": [{"name": one.name, **one.distances} for one in self.variants],
        }


def _variants(scene: "MujocoScene", audit: Audit) -> Iterator[Variant]:
    step = float(scene.model.opt.timestep)
    for shorter in (step / 2, step / 4):
        changed = scene.with_step(shorter)
        yield Variant(*distances(audit, changed), f"time step {1e3 * shorter:g} ms")
    yield Variant(*distances(audit, scene.with_integrator(EXACT)), f"integrator {EXACT}")
