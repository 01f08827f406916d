"""Effects of a list that a scene has no attributes for, with their cost."""

from collections.abc import Iterator

from rallygap.models.ball.catalogue import catalogue
from rallygap.models.ball.simulator import Simulator
from rallygap.models.engines.engine import EffectsEngine
from rallygap.models.engines.mujoco.scene import MujocoScene
from rallygap.models.gap.hypotheses import Hypothesis
from rallygap.pipeline.engines.export.scene.flight import Target, differs, is_shell
from rallygap.pipeline.engines.export.scene.verification import (
    AFTER,
    BEFORE,
    FLIGHT,
    VerificationShots,
    distances,
)
from rallygap.pipeline.web.numbers import number, with_unit

# Effects that have attributes; those of "table_bounce" are a matter of the verification.
STATED = {
    "gravity", "frame_tilt", "buoyancy", "added_mass", "wind", "drag", "magnus", "linear_drag",
    "table_bounce",
}  # fmt: skip
ELSEWHERE = {
    "table_height": "move the geom of the table by it",
    "table_tilt": "turn the geom of the table by it",
    "net": "it belongs to the geom of the net, which remains",
    "racket_bounce": "it belongs to the geom of the racket, which remains",
}
SMALLEST_MM = 0.05  # a cost that is worth a sentence
SAME_DRAG = 1e-4  # 1/s


def unsupported(
    scene: MujocoScene, before: Simulator, after: Simulator, shots: VerificationShots
) -> Iterator[str]:
    """Yield what a list changes and no attribute states, in sentences.

    Args:
        scene: amended.
        before: what the scene did.
        after: what it is to do.
        shots: over which a cost is the largest distance.
    """
    for effect in after.effects:
        if effect in STATED or catalogue()[effect].acts == "sensor":
            continue
        parameters = [Hypothesis(effect, own.name) for own in catalogue()[effect].parameters]
        changed = [own for own in parameters if differs(own.value(before), own.value(after))]
        cost = _cost(effect, after, shots) if changed else 0.0
        if cost > SMALLEST_MM or (changed and effect in ELSEWHERE):
            yield _sentence(changed, after, cost)
    yield from _viscosity(scene, before, after)
    if "table_bounce" in after.effects and not is_shell(scene):
        yield (
            "The ball is no shell, whose inertia is 2/3 m r^2: its <inertial> or another geom says "
            "otherwise, so its grip at the table differs."
        )


def _cost(effect: str, after: Simulator, shots: VerificationShots) -> float:
    """Return the largest distance, mm, that a list makes without an effect."""
    rest = {name: values for name, values in after.effects.items() if name != effect}
    full, reduced = (EffectsEngine("list", simulator) for simulator in (after, Simulator(rest)))
    if catalogue()[effect].acts == "flight":
        return distances(full, reduced, shots.flights, FLIGHT).largest
    return distances(full, reduced, shots.bounces, BEFORE + AFTER).largest


def _sentence(changed: list[Hypothesis], after: Simulator, cost: float) -> str:
    values = ", ".join(
        f"{own.identity} {with_unit(own.value(after), own.declaration.unit)}" for own in changed
    )
    effect = changed[0].effect
    hint = f" ({ELSEWHERE[effect]})" if effect in ELSEWHERE else ""
    in_flight = catalogue()[effect].acts == "flight"
    place = f"after {FLIGHT:g} s of flight" if in_flight else f"{AFTER:g} s after a bounce"
    size = f"; without it the ball is up to {cost:.3g} mm off {place}" if cost else ""
    return f"No attribute here says {values}{hint}{size}."


def _viscosity(scene: MujocoScene, before: Simulator, after: Simulator) -> Iterator[str]:
    known, wanted = (Target.of(law.effects).linear for law in (before, after))
    if not differs(known, wanted):
        return
    damped = float(scene.model.dof_damping[scene.ball.velocity]) / scene.ball.mass
    if wanted < damped - SAME_DRAG:
        yield (
            f"linear_drag.k1 {number(wanted)} 1/s is less than the {number(damped)} 1/s of the "
            "free joint's damping, or below 0; viscosity is 0."
        )
    elif wanted > damped + SAME_DRAG:
        yield (
            f"Viscosity, which says linear_drag.k1, also slows spin, by {number(2.0 * wanted)} of "
            "it per second."
        )
