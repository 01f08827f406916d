"""Probe shots: states of balls that show every effect of flight and of the bounce; their flights.

Flights start high above the middle of the table and meet nothing. Bounces start just above the
table, on the half that they leave, so they meet no net.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import product

import numpy as np

from rallygap.models.ball.simulator import Simulator
from rallygap.models.ball.state import BALL_RADIUS, POSITION, SPIN
from rallygap.models.ball.types import Floats
from rallygap.models.gap.hypotheses import Hypothesis
from rallygap.models.gap.types import Phase

FLIGHT_TIMES: Floats = 0.05 * np.arange(1.0, 9.0)  # s
BOUNCE_TIMES = np.array([0.03, 0.06, 0.1, 0.15])  # s, all after the contact
HEIGHT = 2.0  # m, of the first state of a flight
BEFORE = 0.01  # s from the first state of a bounce to the contact
GRAVITY = 9.81  # m/s^2, only for the time of the contact

SPEEDS = (3.0, 6.0, 9.0, 12.0, 16.0)  # m/s
SPINS = (100.0, 250.0, 450.0)  # rad/s
AXES = np.vstack([np.eye(3), -np.eye(3)])  # of the spins
COURSES = np.radians([10.0, -10.0, 100.0, -80.0])  # from y, of flights to both ends and both sides
CLIMBS = np.radians([15.0, -10.0, 5.0, 0.0])  # of these

FALLS = (1.5, 3.0, 5.0)  # m/s
PACES = (0.0, 2.0, 6.0, 11.0)  # m/s along the table
BOUNCE_SPINS = (0.0, 150.0, -150.0, 350.0, -350.0)  # rad/s
PLACES = ((-0.4, 0.5), (0.0, 0.7), (0.3, 0.4))  # m, of the first state, from the net

MM = 1e3  # in a metre
MM_PER_SPIN = 0.2  # mm that a rad/s counts as; about its Magnus effect on the rest of a flight


@dataclass(frozen=True)
class Probes:
    """Probe shots of one phase.

    Attributes:
        phase: that they show.
        states: (B, 9) first states.
        times: (T,) s, at which they are compared.
    """

    phase: Phase
    states: Floats
    times: Floats

    def __len__(self) -> int:
        return len(self.states)

    def __getitem__(self, rows: slice) -> "Probes":
        """Return some of the shots."""
        return Probes(self.phase, self.states[rows], self.times)


@dataclass(frozen=True)
class Flown:
    """Flights of probe shots by an engine.

    Attributes:
        probes: the B shots.
        states: (B, T, 9) of the engine.
    """

    probes: Probes
    states: Floats

    def residuals(self, simulator: Simulator) -> Floats:
        """Return (B, T, 6) differences of a simulator's positions, mm, and of its scaled spins."""
        own = simulator.fly(self.probes.states, self.probes.times).states
        away = own - self.states
        positions, spins = MM * away[..., POSITION], MM_PER_SPIN * away[..., SPIN]
        return np.concatenate([positions, spins], axis=-1)

    def rms(self, simulator: Simulator) -> float:
        """Return the root mean square of the residuals of a coordinate, mm."""
        return rms(self.residuals(simulator))

    def distances(self, simulator: Simulator) -> Floats:
        """Return (B, T) distances of a simulator's positions, mm."""
        return np.linalg.norm(self.residuals(simulator)[..., :3], axis=-1)

    def slopes(self, simulator: Simulator, parameters: Sequence[Hypothesis]) -> Floats:
        """Return (B T 6, P) derivatives of the residuals, flattened, by parameters."""
        here, columns = self.residuals(simulator), []
        for parameter in parameters:
            near = parameter.nearby(simulator)
            change = self.residuals(parameter.at(simulator, near)) - here
            columns.append((change / (near - parameter.value(simulator))).ravel())
        return np.stack(columns, axis=-1)


def rms(residuals: Floats) -> float:
    """Return the root mean square of residuals."""
    return float(np.sqrt(np.mean(residuals**2)))


def flight_probes() -> Probes:
    """Return balls without spin, and with spins about all axes, in all directions; one is still."""
    states = [np.r_[0.0, 0.0, HEIGHT, np.zeros(6)]]
    for number, (speed, spin) in enumerate(product(SPEEDS, (0.0, *SPINS))):
        for k in range(len(AXES) if spin else 1):
            course = (number + k) % len(COURSES)
            velocity = speed * _direction(COURSES[course], CLIMBS[course])
            states.append(np.r_[0.0, 0.0, HEIGHT, velocity, spin * AXES[k]])
    return Probes("flight", np.array(states), FLIGHT_TIMES)


def bounce_probes() -> Probes:
    """Return balls that meet the table at many angles, with spins about all axes."""
    states = []
    for number, (fall, pace, spin) in enumerate(product(FALLS, PACES, BOUNCE_SPINS)):
        axis, half = np.eye(3)[number % 3], 1.0 if number % 2 else -1.0
        velocity = half * pace * _direction(np.radians(10.0 * (number % 3 - 1)), 0.0)
        velocity[2] = GRAVITY * BEFORE - fall
        x, y = PLACES[number % len(PLACES)]
        contact = np.array([x, half * y, BALL_RADIUS - GRAVITY * BEFORE**2 / 2])
        states.append(np.r_[contact - BEFORE * velocity, velocity, spin * axis])
    return Probes("table", np.array(states), BOUNCE_TIMES)


def _direction(course: float, climb: float) -> Floats:
    level = np.cos(climb)
    return np.array([-np.sin(course) * level, np.cos(course) * level, np.sin(climb)])
