"""Simulated rallies with known contacts, of a ball that shares no equation with the models."""

from dataclasses import dataclass

import numpy as np

from experiments.exam.simulate.independent_ball import IndependentBall
from experiments.exam.simulate.laws import physics_of
from rallygap.models.ball.simulators import shipped
from rallygap.models.segmentation.scoring import observable
from rallygap.models.segmentation.settings import ScoringSettings

BALL = IndependentBall(
    physics_of(shipped("literature"))._replace(
        drag_cd=0.56, magnus_cm=0.08, table_bounce_restitution=0.92, table_bounce_friction=0.22
    )
)
RADIUS, DRAG, GRAVITY = 0.02, 0.14, np.array([0.0, 0.0, -9.81])
START = 12.0  # s, of the clock


@dataclass
class Rally:
    """Measured samples of a rally with its true contacts and velocities."""

    t: np.ndarray
    x: np.ndarray
    contacts: list[tuple[float, str]]
    velocity: np.ndarray
    outlier: np.ndarray


def simulated_rally(rng, strokes=5, noise=0.003, outliers=0.03, dropouts=0.03, bursts=1.0):
    """Draw a rally and measure it at 200 Hz with jitter.

    ``noise`` (m) is that of a coordinate, ``outliers`` are 30 to 500 mm off, and ``bursts`` is the
    rate (1/s) of gaps of 3 to 10 samples.
    """
    played, contacts, end = _played(rng, strokes)
    t = START + np.arange(0.0, end - START, 0.005)
    t = np.sort(t + rng.uniform(-3e-4, 3e-4, len(t)))
    keep = rng.random(len(t)) > dropouts
    for begin in np.flatnonzero(rng.random(len(t)) < bursts * 0.005):
        keep[begin : begin + rng.integers(3, 11)] = False
    t = t[keep]
    begins = [begin for begin, _ in played]
    owner = np.maximum(np.searchsorted(begins, t, side="right") - 1, 0)
    flights = [
        BALL.fly(state, t[owner == number] - begin).states[0]
        for number, (begin, state) in enumerate(played)
    ]
    states = np.concatenate(flights)
    x = states[:, :3] + rng.normal(0.0, noise, (len(t), 3))
    outlier = rng.random(len(t)) < outliers
    directions = rng.normal(size=(outlier.sum(), 3))
    directions /= np.linalg.norm(directions, axis=1, keepdims=True)
    x[outlier] += directions * rng.uniform(0.03, 0.5, (outlier.sum(), 1))
    return Rally(t, x, contacts, states[:, 3:6], outlier)


def _played(rng, strokes):
    """Return times and states just after all strokes, the contacts, and the end."""
    side = rng.choice([-1, 1])
    state = np.array([rng.uniform(-0.5, 0.5), side * 1.5, 0.25, *np.zeros(6)])
    time, played, contacts = START, [], []
    for stroke in range(strokes + 1):
        if stroke:
            contacts.append((time, "racket"))
        # A half volley at one end, a stroke far behind the table at the other.
        wait = rng.choice([rng.uniform(0.016, 0.05), rng.uniform(0.05, 0.35)], p=[0.3, 0.7])
        state, bounce = _stroke(rng, state, side, wait)
        played.append((time, state))
        contacts.append((time + bounce, "table"))
        state = BALL.fly(state, [bounce + wait]).states[0, 0]
        time, side = time + bounce + wait, -side
    return played, contacts, time


def _stroke(rng, state, side, wait):
    """Play a ball that bounces once on the other half; return its state, and when it bounces."""
    while True:
        target = np.array([rng.uniform(-0.6, 0.6), -side * rng.uniform(0.4, 1.25), RADIUS])
        duration = rng.uniform(0.22, 0.6)
        velocity = (target - state[:3]) / duration - 0.5 * GRAVITY * duration
        velocity[:2] *= 1.0 + 0.5 * DRAG * np.hypot(*velocity[:2]) * duration
        played = np.concatenate([state[:3], velocity, rng.normal(0.0, 120.0, 3)])
        contacts = BALL.fly(played, [2.0]).contacts
        bounce, landed = contacts.time[0, 0], contacts.before[0, 0]
        is_last = not contacts.time[0, 1] < bounce + wait
        if is_last and abs(landed[0]) < 0.76 and -side * landed[1] > 0.1 and landed[5] < -1:
            return played, bounce


def scores(pairs, kind, tolerance=0.005):
    """Precision and recall of the observable contacts of one kind, of rallies and what is found."""
    found_true = found_false = missed = 0
    for rally, found in pairs:
        moments = np.array([time for time, _ in rally.contacts])
        seen = observable(moments, rally.t[~rally.outlier], ScoringSettings())
        pairs_of_kind = zip(rally.contacts, seen, strict=True)
        true = [(time, is_seen) for (time, what), is_seen in pairs_of_kind if what == kind]
        times = np.array([contact.time for contact in found if contact.kind == kind])
        for time in times:
            near = [is_seen for at, is_seen in true if abs(at - time) < tolerance]
            found_true += any(near)
            found_false += not near
        missed += sum(is_seen and not np.any(abs(times - at) < tolerance) for at, is_seen in true)
    return found_true / (found_true + found_false), found_true / (found_true + missed)
