"""Omnibus terms: generic forces, bounce errors and sensor errors, independent of the catalogue.

In flight: accelerations along the ball's velocity, across it by the Magnus direction, sideways and
in the frame's directions, and a loss of spin, each times powers of speed u and of spin ratio S. At
the table: kicks (trajectory.py) times what a bounce depends on, kicks in the frame's directions,
and a surface that is elsewhere (bounce_terms.py). In the sensor: errors of positions that grow with
place, speed and time, and of labels (sensor_terms.py). Most structure that the catalogue leaves
lies in the span of these, and a good part along one of them.
"""

from dataclasses import replace

import numpy as np

from models.ball.state import BALL_RADIUS, SPIN, VELOCITY
from models.ball.types import Floats
from models.gap.fit.linearize import Linearised
from models.gap.locate.bounce_terms import of_bounces
from models.gap.locate.propagation import after_forcing
from models.gap.locate.sensor_terms import of_sensor
from models.gap.locate.terms import TYPICAL_SPEED, Flown, Term, Terms

UP = np.array([0.0, 0.0, 1.0])
# Powers of speed (beyond what the direction has) and of spin ratio.
POWERS = {
    "u": ((0, 0), (1, 0), (2, 0), (1, 1)),
    "w x u": ((0, 0), (1, 0), (0, 1), (0, 2), (2, 1)),
    "side": ((1, 0), (0, 0), (1, 1)),
    "x": ((0, 0), (1, 0)),
    "y": ((0, 0), (1, 0)),
    "z": ((0, 0), (1, 0)),
    "-w": ((0, 0), (1, 0)),
}


def with_terms(linear: Linearised) -> Linearised:
    """Return linearised shots with the basis among their columns."""
    terms = terms_about(linear)

    def put(columns: Floats, more: Floats) -> Floats:
        return np.concatenate([columns[..., :-1], more, columns[..., -1:]], axis=-1)

    return replace(
        linear,
        columns=(*linear.columns, *terms.terms),
        positions=put(linear.positions, terms.positions),
        labels=put(linear.labels, terms.labels),
    )


def terms_about(linear: Linearised) -> Terms:
    """Return the terms about linearised shots, zero where a measurement is not used."""
    flown = Flown.of(linear)
    terms, forcings = _forcings(flown.states)
    flight = flown.measured_changes(terms, after_forcing(flown.arcs, forcings))
    whole = Terms.together([flight, of_bounces(flown), of_sensor(flown)])
    whole.positions[~linear.sampled] = 0.0
    whole.labels[~linear.labelled] = 0.0
    return whole


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
