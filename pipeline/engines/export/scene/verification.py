"""Exported models verified: the same shots in the user's engine and in ours."""

from collections.abc import Iterator
from dataclasses import dataclass
from typing import NamedTuple

import mujoco
import numpy as np

from rallygap.models.audit.launches import launches
from rallygap.models.ball.contact_laws import TABLE
from rallygap.models.ball.simulator import Simulator
from rallygap.models.ball.simulators import shipped
from rallygap.models.ball.state import POSITION, TABLE_HALF_LENGTH, TABLE_HALF_WIDTH
from rallygap.models.ball.types import Floats
from rallygap.models.engines.engine import EffectsEngine, Engine, EngineError
from rallygap.models.engines.mujoco.contact import table_contact
from rallygap.models.engines.mujoco.scene import MujocoScene
from rallygap.pipeline.web.numbers import number

SHOTS = 200
SEED = 0
EACH = 5  # of the shots, that slow engines fly
FLIGHT = 0.6  # s
RAISED = 4.0  # m, of flights, so that they meet nothing
BEFORE, AFTER = 0.01, 0.15  # s, of a bounce
# m, from the centre: a compliant contact may end beyond an edge that is nearer than 0.1 m.
EDGES = (TABLE_HALF_WIDTH - 0.1, TABLE_HALF_LENGTH - 0.1)
FLIGHT_LIMIT, BOUNCE_LIMIT = 1.0, 3.0  # mm
EXACT = "RK4"
HALVINGS = 4  # of the time step that are tried
SMALLEST = 0.001  # mm, below which sizes are not told apart
MM, MS = 1e3, 1e3


@dataclass(frozen=True)
class VerificationShots:
    """Strokes and serves, the same for every model.

    Attributes:
        flights: (200, 9) launches, far above the table.
        bounces: (B, 9) states of the same shots 10 ms before they meet the table.
    """

    flights: Floats
    bounces: Floats

    @classmethod
    def of(cls, simulator: Simulator) -> "VerificationShots":
        """Return the shots, with the bounces that they have in a simulator.

        Bounces are well inside the table, and no other contact follows them soon.
        """
        launched = launches(shipped("literature"), SHOTS, 2, np.random.default_rng(SEED)).states
        flights = launched.copy()
        flights[:, 2] += RAISED
        contacts = simulator.fly(launched, [1.0]).contacts
        moments = contacts.time[:, 0] - BEFORE
        inside = (np.abs(contacts.before[:, 0, :2]) < EDGES).all(axis=1)
        bounce = inside & (contacts.surface[:, 0] == TABLE) & (moments > 0.0)
        states = simulator.fly(launched[bounce], moments[bounce][:, None]).states[:, 0]
        alone = simulator.fly(states, [BEFORE + AFTER]).contacts.count == 1
        return cls(flights, np.asarray(states[alone]))

    def some(self) -> "VerificationShots":
        """Return every fifth of the shots, for an engine that is slow."""
        return VerificationShots(self.flights[::EACH], self.bounces[::EACH])


class Agreement(NamedTuple):
    """Distances of an engine from a list of effects, mm.

    Attributes:
        flight: (200,) after 0.6 s.
        bounce: (B,) 0.15 s after a contact with the table; None where the list or the scene has
            none.
    """

    flight: Floats
    bounce: Floats | None

    def sentences(self, name: str) -> Iterator[str]:
        """Yield what is met and what is not, with its size."""
        place = f"after {FLIGHT:g} s of flight"
        yield _sentence(name, "shots", place, self.flight, FLIGHT_LIMIT)
        if self.bounce is not None:
            place = f"{AFTER:g} s after a bounce"
            yield _sentence(name, "bounces", place, self.bounce, BOUNCE_LIMIT)


def distances(engine: Engine, other: Engine, states: Floats, time: float) -> Floats:
    """Return the (B,) distances in mm at a time (s) after the (B, 9) first states.

    Raises:
        EngineError: an engine fails.
    """
    times = np.array([time])
    apart = (engine.fly(states, times) - other.fly(states, times))[:, 0, POSITION]
    return MM * np.linalg.norm(apart, axis=-1)


def agreement(
    engine: Engine, simulator: Simulator, shots: VerificationShots, step: float, bounces: bool
) -> Agreement:
    """Fly the shots of a list of effects in an engine and with the list.

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
    return Agreement(flight, bounce)


def scene_sentences(
    scene: MujocoScene, simulator: Simulator, shots: VerificationShots, name: str
) -> Iterator[str]:
    """Yield how far a scene is from a list of effects, and which time step brings it near.

    Sentences call the scene by the ``name`` of its file; the shots are those of the list.

    Raises:
        EngineError: the scene fails at its own time step.
    """
    contact = table_contact(scene.model, scene.ball, scene.frame)
    agreed = agreement(scene, simulator, shots, _step(scene), contact is not None)
    yield from agreed.sentences(f"{name}, {_variant(scene)}")
    if agreed.flight.max() > FLIGHT_LIMIT:
        yield _finer(scene, simulator, shots, name)
    if contact is None and "table_bounce" in simulator.effects:
        yield f"{name} has no contact of ball and table, so bounces are not compared."
    elif contact and agreed.bounce is not None and agreed.bounce.max() > BOUNCE_LIMIT:
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
            apart = distances(finer, known, shots.flights, _multiple(FLIGHT, _step(finer))).max()
        except EngineError:
            continue
        if apart <= FLIGHT_LIMIT:
            return (
                f"With {_variant(finer)}, {name} flies within {_mm(apart)}; integrator and time "
                "step are left to you."
            )
    return f"Neither does {name} with {EXACT} and time steps down to {MS * _step(finer):g} ms."


def _sentence(name: str, what: str, place: str, sizes: Floats, limit: float) -> str:
    largest = float(sizes.max())
    verdict = "within" if largest <= limit else f"{_mm(largest - limit)} over"
    return (
        f"{name}: {len(sizes)} {what} differ from the list by at most {_mm(largest)} {place} (95 % "
        f"by at most {_mm(float(np.quantile(sizes, 0.95)))}), {verdict} the limit of {limit:g} mm."
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
