"""Simulated rallies with known contacts, integrated by scipy independently of the models."""

from dataclasses import dataclass

import numpy as np
from scipy.integrate import solve_ivp

RADIUS, DRAG, LIFT, GRAVITY = 0.02, 0.14, 0.0012, np.array([0.0, 0.0, -9.81])
RESTITUTION, FRICTION = 0.92, 0.22


@dataclass
class Rally:
    """Measured samples of a rally with its true contacts and velocities."""

    t: np.ndarray
    x: np.ndarray
    contacts: list[tuple[float, str]]
    velocity: np.ndarray
    outlier: np.ndarray

    def observable(self, time, reach=0.025, fewest=3):
        """Whether enough good samples lie on both sides of a contact, up to the next contact."""
        good, times = self.t[~self.outlier], [contact[0] for contact in self.contacts]
        before = max([time - reach, *(other for other in times if other < time)])
        after = min([time + reach, *(other for other in times if other > time)])
        return (
            np.sum((good > before) & (good < time)) >= fewest
            and np.sum((good > time) & (good < after)) >= fewest
        )


def simulated_rally(rng, strokes=5, noise=0.003, outliers=0.03, dropouts=0.03, bursts=1.0):
    """Draw a rally and measure it at 200 Hz with jitter.

    Args:
        rng: numpy's random generator.
        strokes: how many strokes follow the first.
        noise: standard deviation of a coordinate, m.
        outliers: share of samples 30 to 500 mm off.
        dropouts: share of samples that are missing.
        bursts: rate (1/s) of gaps of 3 to 10 samples.
    """
    pieces, contacts = _played(rng, strokes)
    end = pieces[-1][1]
    t = np.arange(0.0, end, 0.005)
    t = np.sort(t + rng.uniform(-3e-4, 3e-4, len(t))) + 12.0
    keep = rng.random(len(t)) > dropouts
    for begin in np.flatnonzero(rng.random(len(t)) < bursts * 0.005):
        keep[begin : begin + rng.integers(3, 11)] = False
    t = t[keep]
    states = np.array([_state(pieces, time - 12.0) for time in t])
    x = states[:, :3] + rng.normal(0.0, noise, (len(t), 3))
    outlier = rng.random(len(t)) < outliers
    directions = rng.normal(size=(outlier.sum(), 3))
    directions /= np.linalg.norm(directions, axis=1, keepdims=True)
    x[outlier] += directions * rng.uniform(0.03, 0.5, (outlier.sum(), 1))
    contacts = [(time + 12.0, kind) for time, kind in contacts]
    return Rally(t, x, contacts, states[:, 3:6], outlier)


def _played(rng, strokes):
    """Return (start, end, solution) of every flight, and the contacts between them."""
    side = rng.choice([-1, 1])
    state = np.array([rng.uniform(-0.5, 0.5), side * 1.5, 0.25, *np.zeros(6)])
    time, pieces, contacts = 0.0, [], []
    for stroke in range(strokes + 1):
        if stroke:
            contacts.append((time, "racket"))
        flight, state = _stroke(rng, state, side)
        bounce = flight.t[-1]
        pieces.append((time, time + bounce, flight.sol))
        time += bounce
        contacts.append((time, "table"))
        state = _bounced(state)
        # A half volley at one end, a stroke far behind the table at the other.
        wait = rng.choice([rng.uniform(0.016, 0.05), rng.uniform(0.05, 0.35)], p=[0.3, 0.7])
        flight = solve_ivp(_motion, (0, wait), state, rtol=1e-7, atol=1e-9, dense_output=True)
        pieces.append((time, time + wait, flight.sol))
        state, time, side = flight.y[:, -1], time + wait, -side
    return pieces, contacts


def _stroke(rng, state, side):
    """Play a ball that comes down on the other half; return its flight and state there."""
    while True:
        target = np.array([rng.uniform(-0.6, 0.6), -side * rng.uniform(0.4, 1.25), RADIUS])
        duration = rng.uniform(0.22, 0.6)
        velocity = (target - state[:3]) / duration - 0.5 * GRAVITY * duration
        velocity[:2] *= 1.0 + 0.5 * DRAG * np.hypot(*velocity[:2]) * duration
        played = np.concatenate([state[:3], velocity, rng.normal(0.0, 120.0, 3)])
        flight = solve_ivp(
            _motion, (0, 2), played, events=_table, rtol=1e-7, atol=1e-9, dense_output=True
        )
        landed = flight.y[:, -1]
        if abs(landed[0]) < 0.76 and 0.1 < -side * landed[1] < 1.37 and landed[5] < -1:
            return flight, landed


def _motion(_, state):
    velocity, spin = state[3:6], state[6:]
    acceleration = GRAVITY - DRAG * np.linalg.norm(velocity) * velocity
    acceleration = acceleration + LIFT * np.cross(spin, velocity)
    return np.concatenate([velocity, acceleration, np.zeros(3)])


def _table(_, state):
    return state[2] - RADIUS


_table.terminal, _table.direction = True, -1


def _bounced(state):
    """Coulomb friction, until the ball rolls."""
    velocity, spin = state[3:6].copy(), state[6:].copy()
    slip = np.array([velocity[0] - RADIUS * spin[1], velocity[1] + RADIUS * spin[0], 0.0])
    impulse = (1 + RESTITUTION) * -velocity[2]
    tangential = -slip * min(FRICTION * impulse / np.linalg.norm(slip), 0.4)
    spin += 1.5 / RADIUS * np.cross([0, 0, -1], tangential)
    velocity += tangential
    velocity[2] *= -RESTITUTION
    return np.concatenate([state[:3], velocity, spin])


def _state(pieces, time):
    for begin, end, solution in pieces:
        if time <= end:
            return solution(max(time - begin, 0.0))
    return pieces[-1][2](time - pieces[-1][0])


def scores(pairs, kind, tolerance=0.005):
    """Precision and recall of the observable contacts of one kind.

    Args:
        pairs: (rally, contacts found).
        kind: ``racket`` or ``table``.
        tolerance: s.
    """
    found_true = found_false = missed = 0
    for rally, found in pairs:
        true = [(time, rally.observable(time)) for time, what in rally.contacts if what == kind]
        times = np.array([contact.time for contact in found if contact.kind == kind])
        for time in times:
            near = [observable for at, observable in true if abs(at - time) < tolerance]
            found_true += any(near)
            found_false += not near
        missed += sum(
            observable and not np.any(abs(times - at) < tolerance) for at, observable in true
        )
    return found_true / (found_true + found_false), found_true / (found_true + missed)
