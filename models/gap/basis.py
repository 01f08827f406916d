"""Basis: an omnibus of what may act on a ball, at a bounce and in a sensor, by no effect's name.

In flight: accelerations along the ball's velocity, across it by the Magnus direction, sideways and
in the frame's directions, and a loss of spin, each times powers of speed u and of spin ratio S. At
the table: kicks (motion.py) times what a bounce depends on. In the sensor: errors of positions that
grow with place, speed and time, and of labels. Whatever structure is left when the catalogue is
exhausted, most of it lies in the span of these.
"""

from dataclasses import dataclass

import numpy as np

from models.ball.simulator import Simulator
from models.ball.state import BALL_RADIUS, POSITION, SPIN, STATE_SIZE, VELOCITY
from models.ball.types import Floats
from models.gap.hypotheses import Hypothesis
from models.gap.linear import Linearised, label_units
from models.gap.motion import KICK_SIZE, Moments
from models.gap.variation import Arc, arcs, response

UP = np.array([0.0, 0.0, 1.0])
TYPICAL_SPEED = 8.0  # m/s, so that numbers in a formula are of similar size
TYPICAL_FALL = 3.0  # m/s
# Powers of speed (beyond what the direction has) and of spin ratio.
POWERS = {
    "u": ((0, 0), (1, 0), (2, 0), (1, 1)),
    "w x u": ((0, 0), (1, 0), (0, 1), (0, 2), (2, 1)),
    "side": ((1, 0), (0, 0), (1, 1)),
    "x": ((0, 0),),
    "y": ((0, 0),),
    "z": ((0, 0), (1, 0)),
    "-w": ((0, 0), (1, 0)),
}


@dataclass(frozen=True)
class Term(Hypothesis):
    """One term of the basis: ``effect`` is the phase, ``parameter`` its formula."""

    def listed(self, simulator: Simulator) -> bool:
        """No simulator lists a term."""
        return False


@dataclass(frozen=True)
class Basis:
    """Terms and their columns of B shots, like those of the hypotheses (linear.py).

    Attributes:
        terms: the D terms.
        positions: (B, N, 3, D).
        labels: (B, L, 3, D).
    """

    terms: tuple[Term, ...]
    positions: Floats
    labels: Floats


def basis(linear: Linearised) -> Basis:
    """Return the basis about linearised shots."""
    moments = Moments.of(linear.shots)
    found = arcs(linear.simulator, linear.unknowns, moments.times)
    states = np.zeros((*moments.times.shape, STATE_SIZE))
    for arc in found:
        states[arc.rows] = np.where(arc.inside[..., None], arc.states, states[arc.rows])
    flight, forcing = _forcings(states)
    path = response(found, forcing)
    places = np.take_along_axis(path, moments.samples[..., None, None], axis=1)
    parts = [
        (flight, places, np.zeros((*linear.labels.shape[:3], len(flight)))),
        _table(linear, found),
        _sensor(linear, states, moments),
    ]
    terms = tuple(term for part in parts for term in part[0])
    positions = np.concatenate([part[1] for part in parts], axis=3)
    labels = np.concatenate([part[2] for part in parts], axis=3)
    positions[~linear.sampled] = 0.0
    labels[~linear.labelled] = 0.0
    return Basis(terms, positions, labels)


def _forcings(states: Floats) -> tuple[list[Term], Floats]:
    """Return the terms of flight, and (B, T, 9, D) what they do to (B, T, 9) states."""
    velocity, spin = states[..., VELOCITY], states[..., SPIN]
    speed = np.maximum(np.linalg.norm(velocity, axis=-1, keepdims=True), 0.1)
    ratio = BALL_RADIUS * np.linalg.norm(spin, axis=-1, keepdims=True) / speed
    directions = {
        "u": velocity,
        "w x u": np.cross(spin, velocity) * BALL_RADIUS / TYPICAL_SPEED,
        "side": np.cross(velocity, UP),
        "x": np.broadcast_to([1.0, 0.0, 0.0], velocity.shape),
        "y": np.broadcast_to([0.0, 1.0, 0.0], velocity.shape),
        "z": np.broadcast_to(UP, velocity.shape),
        "-w": -spin,
    }
    terms, forcings = [], []
    for name, direction in directions.items():
        for of_speed, of_ratio in POWERS[name]:
            forcing = np.zeros(states.shape)
            part = SPIN if name == "-w" else VELOCITY
            forcing[..., part] = direction * (speed / TYPICAL_SPEED) ** of_speed * ratio**of_ratio
            terms.append(Term("flight", _formula(name, of_speed, of_ratio)))
            forcings.append(forcing)
    return terms, np.stack(forcings, axis=-1)


def _formula(direction: str, of_speed: int, of_ratio: int) -> str:
    factors = [direction]
    factors += [f"(|u|/{TYPICAL_SPEED:g})^{of_speed}"] if of_speed else []
    factors += [f"S^{of_ratio}"] if of_ratio else []
    return " ".join(factors)


def _table(linear: Linearised, found: list[Arc]) -> tuple[list[Term], Floats, Floats]:
    """Return the terms of bounces: kicks that depend on the state before."""
    count = (linear.own - STATE_SIZE) // KICK_SIZE
    shape = linear.positions.shape[:3], linear.labels.shape[:3]
    names: list[Term] = []
    positions: list[Floats] = []
    labels: list[Floats] = []
    factors = [_impact(arc, len(linear.shots)) for arc in found[:count]]
    for kick, of in enumerate(("n", "s", "c")):
        for name in factors[0] if factors else ():
            places, spins = np.zeros(shape[0]), np.zeros(shape[1])
            for number in range(count):
                column = STATE_SIZE + KICK_SIZE * number + kick
                factor = factors[number][name][:, None, None] if number < len(factors) else 0.0
                places += factor * linear.positions[..., column]
                spins += factor * linear.labels[..., column]
            names.append(Term("table", f"{of} {name}".strip()))
            positions.append(places)
            labels.append(spins)
    if not names:
        return [], np.zeros((*shape[0], 0)), np.zeros((*shape[1], 0))
    return names, np.stack(positions, axis=-1), np.stack(labels, axis=-1)


def _impact(arc: Arc, count: int) -> dict[str, Floats]:
    """Return (B,) what the bounce at the end of an arc may depend on; zero without a bounce."""
    last = np.maximum(arc.inside.sum(axis=1) + (~arc.inside).argmin(axis=1) - 1, 0)
    state = arc.states[np.arange(len(arc.rows)), last]
    bounced = arc.beyond.any(axis=1) & arc.inside.any(axis=1)
    vx, vy, vz, wx, wy, _ = state[:, 3:].T
    fall = np.maximum(np.abs(vz), 0.3)
    slip = np.hypot(vx - BALL_RADIUS * wy, vy + BALL_RADIUS * wx)
    spin = BALL_RADIUS * np.hypot(wx, wy)
    values = {
        "": np.ones_like(fall),
        "v_n": fall / TYPICAL_FALL,
        "slip": slip / TYPICAL_FALL,
        "spin": spin / TYPICAL_FALL,
        "/v_n": TYPICAL_FALL / fall,
        "v_x/v_n": vx / fall,
        "v_y/v_n": vy / fall,
        "/(1 + slip/v_n)": 1 / (1 + (slip / fall) ** 2),
    }
    factors = {}
    for name, value in values.items():
        factors[name] = np.zeros(count)
        factors[name][arc.rows] = np.where(bounced, value, 0.0)
    return factors


def _sensor(
    linear: Linearised, states: Floats, moments: Moments
) -> tuple[list[Term], Floats, Floats]:
    """Return the terms of the sensor: errors of places and of labels."""
    at = np.take_along_axis(states, moments.samples[..., None], axis=1)
    place, velocity = at[..., POSITION], at[..., VELOCITY]
    speed = np.linalg.norm(velocity, axis=-1, keepdims=True)
    spins = np.take_along_axis(states[..., SPIN], moments.labels[..., None], axis=1)
    axes = np.eye(3)
    of_places = {f"{axis} at {axis}": place * axes[i] for i, axis in enumerate("xyz")}
    of_places["-u |u|"] = -velocity * speed
    of_places["z at the bounce"] = _after_bounces(linear) * UP
    units = label_units(spins)[..., None]
    of_labels = {"w": spins / units}
    for i, axis in enumerate("xyz"):
        of_labels[f"{axis} x w"] = np.cross(axes[i], spins) / units
    none = np.zeros(linear.labels.shape[:3])
    nowhere = np.zeros(linear.positions.shape[:3])
    names = [Term("sensor", name) for name in (*of_places, *of_labels)]
    positions = [*of_places.values(), *(nowhere for _ in of_labels)]
    labels = [*(none for _ in of_places), *of_labels.values()]
    return names, np.stack(positions, axis=-1), np.stack(labels, axis=-1)


def _after_bounces(linear: Linearised) -> Floats:
    """Return (B, N, 1) 1 after the first bounce: a surface that is elsewhere than it seems."""
    upwards = np.abs(linear.positions[..., STATE_SIZE:-1][..., :1]).sum(axis=2)
    after: Floats = (upwards > 0).astype(float)
    return after
