"""The omnibus terms: generic forces, bounce errors and sensor errors, independent of the catalogue.

In flight: accelerations along the velocity, across it by the Magnus direction, sideways and in the
frame's directions, and a loss of spin, each times powers of speed u and of spin ratio S. At the
table: bounce_terms.py. In the sensor: errors of positions that grow with place, speed and time, and
errors of labels. Most structure that the catalogue leaves lies in the span of these, and a good
part along one of them.
"""

from dataclasses import replace

import numpy as np

from rallygap.models.ball.state import BALL_RADIUS, POSITION, SPIN, VELOCITY
from rallygap.models.ball.types import Floats
from rallygap.models.gap.fit.linearize import Linearised
from rallygap.models.gap.fit.noise import Noise
from rallygap.models.gap.fit.refit import RefitResult
from rallygap.models.gap.fit.variance_components import NoiseEstimate
from rallygap.models.gap.inference.score_test import Evidence
from rallygap.models.gap.locate.bounce_terms import of_bounces
from rallygap.models.gap.locate.propagation import after_forcing
from rallygap.models.gap.locate.terms import TYPICAL_SPEED, Flown, Term, Terms
from rallygap.models.gap.settings import GapSettings

UP = np.array([0.0, 0.0, 1.0])
TYPICAL_SPIN = 200.0  # rad/s
TYPICAL_TIME = 0.3  # s
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


def evidence_with_terms(
    fit: RefitResult, noise: Noise, settings: GapSettings
) -> tuple[Linearised, Evidence]:
    """Return shots with the omnibus terms among their columns, and their evidence in a noise."""
    return evidence_with(terms_about(fit.linear), fit, noise, settings)


def evidence_with(
    terms: Terms, fit: RefitResult, noise: Noise, settings: GapSettings
) -> tuple[Linearised, Evidence]:
    """Return shots with terms among their columns, and their evidence in a given noise."""
    linear = _with_terms(fit.linear, terms)
    known = NoiseEstimate.known(linear, noise, fit.noise_estimate.weights, settings.fit)
    return linear, Evidence.of(linear, known, settings)


def _with_terms(linear: Linearised, terms: Terms) -> Linearised:
    """Return linearised shots with terms among their columns."""
    end = linear.of_hypotheses.stop

    def put(columns: Floats, more: Floats) -> Floats:
        return np.concatenate([columns[..., :end], more, columns[..., end:]], axis=-1)

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
    whole = Terms.together([flight, of_bounces(flown), _of_sensor(flown)])
    return whole.where_used(linear)


def _forcings(states: Floats) -> tuple[list[Term], Floats]:
    """Return the terms of flight, and (B, T, 9, D) what they do to (B, T, 9) states."""
    velocity, spin = states[..., VELOCITY], states[..., SPIN]
    speed = np.maximum(np.linalg.norm(velocity, axis=-1, keepdims=True), 0.1)
    ratio = BALL_RADIUS * np.linalg.norm(spin, axis=-1, keepdims=True) / speed
    directions = {
        "u": velocity,
        "w x u": np.cross(spin, velocity) * BALL_RADIUS / TYPICAL_SPEED,
        "side": np.cross(velocity, UP),
        **{axis: np.broadcast_to(unit, velocity.shape) for axis, unit in _axes().items()},
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


def _of_sensor(flown: Flown) -> Terms:
    """Return the terms of the sensor: what it adds to positions and labels."""
    shots = flown.linear.shots
    start = shots.times[:, :1]
    of_places = _of_places(flown.sampled, (shots.times - start)[..., None])
    if shots.shared.shape[-1]:  # a smooth error over space is in the model already
        of_places = {name: error for name, error in of_places.items() if " at " not in name}
    since = np.nan_to_num(shots.label_times - start)[..., None]
    of_labels = _of_labels(flown.spins, flown.label_scales[..., None], since)
    names = [Term("sensor", name) for name in (*of_places, *of_labels)]
    positions = np.zeros((*shots.positions.shape, len(names)))
    labels = np.zeros((*shots.labels.shape, len(names)))
    positions[..., : len(of_places)] = np.stack(list(of_places.values()), axis=-1)
    labels[..., len(of_places) :] = np.stack(list(of_labels.values()), axis=-1)
    return Terms(tuple(names), positions, labels)


def _of_places(states: Floats, time: Floats) -> dict[str, Floats]:
    """Return the errors of positions of (B, N, 9) states."""
    place, velocity = states[..., POSITION], states[..., VELOCITY]
    errors = {
        f"{axis} at {other}": place[..., [column]] * direction
        for axis, direction in _axes().items()
        for column, other in enumerate("xyz")
    }
    speed = np.linalg.norm(velocity, axis=-1, keepdims=True)
    return {**errors, "-u |u|": -velocity * speed, "-u t": -velocity * time}


def _of_labels(spins: Floats, scales: Floats, time: Floats) -> dict[str, Floats]:
    """Return the errors of (B, L, 3) labels, in units of the fitted spin."""
    shares = spins / scales
    turned = {f"{axis} x w": np.cross(unit, shares) for axis, unit in _axes().items()}
    growing = {"w |w|": shares * scales / TYPICAL_SPIN, "w t": shares * time / TYPICAL_TIME}
    return {"w": shares, **growing, **turned}


def _axes() -> dict[str, Floats]:
    return dict(zip("xyz", np.eye(3), strict=True))
