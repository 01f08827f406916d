"""Contacts of balls with table, net and floor, within the view of the cameras."""

from dataclasses import dataclass

import numpy as np

from rallygap.models.arena.truth import Truth
from rallygap.models.ball.contact_laws import NET, NONE, ROLLING, TABLE
from rallygap.models.ball.state import BALL_RADIUS, POSITION, SPIN, STATE_SIZE, VELOCITY
from rallygap.models.ball.types import Bools, Floats, Integers

# The surfaces of models.ball.contact_laws, and the floor, which ball simulators do not have.
FLOOR_SURFACE = 3
KINDS = {TABLE: "table", NET: "net", FLOOR_SURFACE: "floor"}

FLOOR = -0.76  # m: a table is 76 cm high (ITTF Law 2.1.2)
FLOOR_RESTITUTION = 0.80  # assumption for a rubber sports floor
FLOOR_FRICTION = 0.40  # assumption
VIEW_HALF_WIDTH = 2.5  # m to each side of the table's middle
VIEW_HALF_LENGTH = 4.5  # m

SCAN_STEP = 0.01  # s between two samples of a path that are checked for floor and view
MAX_ARC = 1.6  # s; a ball lobbed 2.5 m high comes down sooner


@dataclass(frozen=True)
class Arcs:
    """The ends of the arcs of B balls, from one contact to the next."""

    times: Floats  # (B,) s until the next contact, infinite where there is none
    surfaces: Integers  # (B,) numbers of surfaces, NONE where there is no contact
    before: Floats  # (B, 9) states just before the contact
    after: Floats  # (B, 9) states just after, by the law, without scatter
    lost: Floats  # (B,) s until the cameras lose the ball, if no contact comes first


@dataclass(frozen=True)
class ContactSequence:
    """The contacts of B balls, at most K each, until the cameras lose them."""

    times: Floats  # (B, K) s after the first state, infinite beyond the last
    surfaces: Integers  # (B, K) numbers of surfaces, NONE beyond the last
    states: Floats  # (B, K, 9) just after
    last_visible: Floats  # (B,) s, later the ball is out of view or its contacts are not simulated

    def take(self, rows: Integers) -> "ContactSequence":
        """Return the contacts of some of the balls."""
        return ContactSequence(
            self.times[rows], self.surfaces[rows], self.states[rows], self.last_visible[rows]
        )


def follow_contacts(
    truth: Truth, states: Floats, most: int, random: np.random.Generator
) -> ContactSequence:
    """Simulate balls from (B, 9) states up to ``most`` contacts each."""
    count = len(states)
    times, last_visible = np.full((count, most), np.inf), np.zeros(count)
    surfaces, after = np.full((count, most), NONE), np.full((count, most, STATE_SIZE), np.nan)
    going, now, current = np.arange(count), np.zeros(count), states
    for k in range(most + 1):
        arcs = fly_to_contact(truth, current)
        last_visible[going] = now + np.minimum(arcs.times, arcs.lost)
        on = (arcs.times < arcs.lost) & (k < most)
        if not on.any():
            break
        after_contact, bounced = arcs.after.copy(), arcs.surfaces == TABLE
        after_contact[bounced] = truth.scatter.apply(
            truth.simulator, arcs.before[bounced], arcs.after[bounced], random
        )
        current = after_contact[on]
        going, now = going[on], (now + arcs.times)[on]
        times[going, k], surfaces[going, k], after[going, k] = now, arcs.surfaces[on], current
    return ContactSequence(times, surfaces, after, last_visible)


def fly_to_contact(truth: Truth, states: Floats) -> Arcs:
    """Fly (B, 9) states to their next contacts."""
    scan_times = np.arange(0.0, MAX_ARC, SCAN_STEP)
    flight = truth.simulator.fly(states, scan_times)
    met = flight.contacts
    times = np.where(met.count > 0, met.time[:, 0], np.inf)
    floor, on_floor = _floor(truth, flight.states, scan_times)
    first = floor < times
    times = np.where(first, floor, times)
    away = ~in_view(flight.states) & (scan_times < times[:, None])
    return Arcs(
        times,
        np.where(first, FLOOR_SURFACE, met.surface[:, 0]),
        np.where(first[:, None], on_floor, met.before[:, 0]),
        np.where(first[:, None], bounce_off_floor(on_floor), met.after[:, 0]),
        np.where(away.any(axis=1), scan_times[np.maximum(away.argmax(axis=1) - 1, 0)], MAX_ARC),
    )


def _floor(truth: Truth, paths: Floats, scan_times: Floats) -> tuple[Floats, Floats]:
    """Return when balls meet the floor (infinite: not) and their states there (Newton)."""
    level = FLOOR + BALL_RADIUS
    below = (paths[..., 2] < level) & (paths[..., 5] < 0)
    falls = below.any(axis=1)
    last = np.maximum(below.argmax(axis=1) - 1, 0)
    start = paths[np.arange(len(paths)), last]
    state, passed = start.copy(), np.zeros(len(paths))
    for _ in range(4):
        speed = np.minimum(state[:, 5], -1e-3)
        passed = np.clip(passed + (level - state[:, 2]) / speed, 0.0, SCAN_STEP)
        state[falls] = truth.simulator.fly(start[falls], passed[falls, None]).states[:, 0]
    return np.where(falls, scan_times[last] + passed, np.inf), state


def in_view(states: Floats) -> Bools:
    """Return for (..., 9) states whether the cameras see the ball."""
    x, y, z = np.moveaxis(states[..., POSITION], -1, 0)
    return (np.abs(x) < VIEW_HALF_WIDTH) & (np.abs(y) < VIEW_HALF_LENGTH) & (z > FLOOR)


def bounce_off_floor(states: Floats) -> Floats:
    """Return (B, 9) states just after the floor, by the table's contact law (Nakashima 2010)."""
    after = states.copy()
    vx, vy, vz = states[:, VELOCITY].T
    wx, wy, _ = states[:, SPIN].T
    slip = np.stack([vx - BALL_RADIUS * wy, vy + BALL_RADIUS * wx], axis=1)
    grip = FLOOR_FRICTION * (1 + FLOOR_RESTITUTION) * np.abs(vz)
    speed = np.maximum(np.linalg.norm(slip, axis=1), 1e-12)
    alpha = np.minimum(grip / speed, ROLLING)[:, None]
    after[:, 3:5] -= alpha * slip
    after[:, 5] = FLOOR_RESTITUTION * np.abs(vz)
    after[:, 6:8] += 1.5 / BALL_RADIUS * alpha * slip[:, ::-1] * [-1, 1]
    return after
