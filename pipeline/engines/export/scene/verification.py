"""Exported models verified: the same shots in the user's engine and in ours."""

from collections.abc import Iterator
from dataclasses import dataclass

import mujoco

from rallygap.models.ball.simulator import Simulator
from rallygap.models.engines.engine import EffectsEngine, Engine, EngineError
from rallygap.models.engines.mujoco.contact import table_contact
from rallygap.models.engines.mujoco.scene import MujocoScene
from rallygap.pipeline.engines.export.scene.shots import (
    AFTER,
    BEFORE,
    FLIGHT,
    Distances,
    VerificationShots,
    distances,
)
from rallygap.pipeline.web.numbers import number

FLIGHT_LIMIT, BOUNCE_LIMIT = 1.0, 3.0  # mm
EXACT = "RK4"
HALVINGS = 4  # of the time step that are tried
SMALLEST = 0.001  # mm, below which sizes are not told apart
MS = 1e3


@dataclass(frozen=True)
class Agreement:
    """Distances of an engine from a list of effects.

    Attributes:
        flight: after 0.6 s.
        bounce: 0.15 s after a contact with the table; None where the list or the scene has none.
        shots: how many flights.
        bounces: how many bounces.
    """

    flight: Distances
    bounce: Distances | None
    shots: int
    bounces: int

    @property
    def flight_met(self) -> bool:
        """Whether flights are within their limit."""
        return self.flight.largest <= FLIGHT_LIMIT

    @property
    def bounce_met(self) -> bool:
        """Whether bounces are within their limit, where there are any."""
        return self.bounce is None or self.bounce.largest <= BOUNCE_LIMIT

    def sentences(self, name: str) -> Iterator[str]:
        """Yield what is met and what is not, with its size."""
        place = f"after {FLIGHT:g} s of flight"
        yield _sentence(name, self.shots, "shots", place, self.flight, FLIGHT_LIMIT)
        if self.bounce is not None:
            place = f"{AFTER:g} s after a bounce"
            yield _sentence(name, self.bounces, "bounces", place, self.bounce, BOUNCE_LIMIT)


def agreement(
    engine: Engine, simulator: Simulator, shots: VerificationShots, step: float, bounces: bool
) -> Agreement:
    """Fly the shots in an engine and with a list of effects.

    Args:
        engine: to be verified.
        simulator: the list.
        shots: of this list.
        step: s, of the engine; flights are compared at one of its steps.
        bounces: whether both have a table.

    Raises:
        EngineError: the engine fails.
    """
    known = EffectsEngine("the list of effects", simulator)
    flight = distances(engine, known, shots.flights, _multiple(FLIGHT, step))
    bounce = None
    if bounces and len(shots.bounces):
        bounce = distances(engine, known, shots.bounces, _multiple(BEFORE + AFTER, step))
    return Agreement(flight, bounce, len(shots.flights), len(shots.bounces))


def scene_sentences(
    scene: MujocoScene, simulator: Simulator, shots: VerificationShots, name: str
) -> Iterator[str]:
    """Yield how far a scene is from a list of effects, and which time step brings it near.

    Args:
        scene: to be verified.
        simulator: the list.
        shots: of this list.
        name: of the scene's file.

    Raises:
        EngineError: the scene fails at its own time step.
    """
    contact = table_contact(scene.model, scene.ball, scene.frame)
    found = agreement(scene, simulator, shots, _step(scene), contact is not None)
    yield from found.sentences(f"{name}, {_variant(scene)}")
    if not found.flight_met:
        yield _finer(scene, simulator, shots, name)
    if contact is None and "table_bounce" in simulator.effects:
        yield f"{name} has no contact of ball and table, so bounces are not compared."
    elif contact is not None and not found.bounce_met:
        yield (
            f"In {name} a contact lasts {number(MS * contact.duration)} ms or "
            f"{number(contact.duration / _step(scene))} time steps, of which the list knows "
            f"nothing, and ends at most {100 * contact.grip:.0f} % of the slip, whatever the "
            "friction; ball_effects.py has neither limit."
        )


def _finer(scene: MujocoScene, simulator: Simulator, shots: VerificationShots, name: str) -> str:
    """Return the largest time step with RK4 at which flights are near, as a sentence."""
    known = EffectsEngine("the list of effects", simulator)
    for halvings in range(HALVINGS + 1):
        finer = scene.with_integrator(EXACT).with_step(_step(scene) / 2**halvings)
        try:
            found = distances(finer, known, shots.flights, _multiple(FLIGHT, _step(finer)))
        except EngineError:
            continue
        if found.largest <= FLIGHT_LIMIT:
            return (
                f"With {_variant(finer)}, {name} flies within {_mm(found.largest)}; integrator "
                "and time step are left to you."
            )
    return f"Neither does {name} with {EXACT} and time steps down to {MS * _step(finer):g} ms."


def _sentence(name: str, count: int, what: str, place: str, found: Distances, limit: float) -> str:
    excess = found.largest - limit
    verdict = "within" if excess <= 0.0 else f"{_mm(excess)} over"
    return (
        f"{name}: {count} {what} differ from the list by at most {_mm(found.largest)} {place} "
        f"(95 % by at most {_mm(found.most)}), {verdict} the limit of {limit:g} mm."
    )


def _variant(scene: MujocoScene) -> str:
    kind = mujoco.mjtIntegrator(scene.model.opt.integrator).name.removeprefix("mjINT_")
    return f"{kind if kind == EXACT else kind.capitalize()} at {MS * _step(scene):g} ms"


def _step(scene: MujocoScene) -> float:
    return float(scene.model.opt.timestep)


def _multiple(time: float, step: float) -> float:
    """Return the multiple of a time step that is nearest to a time."""
    return max(round(time / step), 1) * step


def _mm(size: float) -> str:
    return f"{size:.3g} mm" if size >= SMALLEST else f"{SMALLEST:g} mm"
