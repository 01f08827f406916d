"""The shots by which an exported model is verified, and distances between two flights of them."""

from dataclasses import dataclass

import numpy as np

from rallygap.models.ball.contact_laws import TABLE
from rallygap.models.ball.simulator import Simulator
from rallygap.models.ball.simulators import shipped
from rallygap.models.ball.state import POSITION, TABLE_HALF_LENGTH, TABLE_HALF_WIDTH
from rallygap.models.ball.types import Floats
from rallygap.models.engines.engine import Engine
from rallygap.models.exam.simulate.launches import launches

SHOTS = 200
SEED = 0
EACH = 5  # of the shots, that slow engines fly
FLIGHT = 0.6  # s
RAISED = 4.0  # m, of flights, so that they meet nothing
BEFORE, AFTER = 0.01, 0.15  # s, of a bounce
# m, from the centre: a compliant contact may end beyond an edge that is nearer than 0.1 m.
EDGES = (TABLE_HALF_WIDTH - 0.1, TABLE_HALF_LENGTH - 0.1)
MM = 1e3


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
        """Return the shots, with the bounces that they have in a simulator."""
        launched = launches(shipped("literature"), SHOTS, 2, np.random.default_rng(SEED)).states
        flights = launched.copy()
        flights[:, 2] += RAISED
        return cls(flights, _before_bounces(simulator, launched))

    def some(self) -> "VerificationShots":
        """Return every fifth of the shots, for an engine that is slow."""
        return VerificationShots(self.flights[::EACH], self.bounces[::EACH])


@dataclass(frozen=True)
class Distances:
    """Distances between two flights of the same shots.

    Attributes:
        largest: mm.
        most: mm, which 95 % of the shots do not exceed.
    """

    largest: float
    most: float


def distances(one: Engine, other: Engine, states: Floats, time: float) -> Distances:
    """Return the distances at a time (s) after the (B, 9) first states, of which there is one.

    Raises:
        EngineError: an engine fails.
    """
    times = np.array([time])
    apart = (one.fly(states, times) - other.fly(states, times))[:, 0, POSITION]
    sizes = MM * np.linalg.norm(apart, axis=-1)
    return Distances(float(sizes.max()), float(np.quantile(sizes, 0.95)))


def _before_bounces(simulator: Simulator, launched: Floats) -> Floats:
    """Return states before first contacts well inside the table that no other one follows soon."""
    contacts = simulator.fly(launched, [1.0]).contacts
    moments = contacts.time[:, 0] - BEFORE
    inside = (np.abs(contacts.before[:, 0, :2]) < EDGES).all(axis=1)
    bounce = inside & (contacts.surface[:, 0] == TABLE) & (moments > 0.0)
    states = simulator.fly(launched[bounce], moments[bounce][:, None]).states[:, 0]
    alone = simulator.fly(states, [BEFORE + AFTER]).contacts.count == 1
    once: Floats = states[alone]
    return once
