"""From contact to contact: where balls meet table, net and floor, each bounce with its scatter."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from models.arena.environment import FLOOR, floor_bounced, in_sight
from models.arena.truth import Truth
from models.ball.contact_laws import NET, NONE, TABLE
from models.ball.state import BALL_RADIUS, STATE_SIZE

Floats = NDArray[np.float64]
Integers = NDArray[np.int64]

# The surfaces of models.ball.contact_laws, and the floor, which no simulator of the ball knows.
FLOOR_SURFACE = 3
KINDS = {TABLE: "table", NET: "net", FLOOR_SURFACE: "floor"}

LOOK = 0.01  # s between two looks at where a ball is
LONGEST_ARC = 1.6  # s without a contact: more than a ball needs that is lobbed 2.5 m high


@dataclass(frozen=True)
class Arcs:
    """How the arcs end that B balls fly.

    Attributes:
        times: (B,) s until the next contact, infinite where there is none.
        surfaces: (B,) numbers of surfaces, ``NONE`` where there is none.
        before: (B, 9) states just before the contact.
        after: (B, 9) states just after, by the law, without scatter.
        lost: (B,) s until the cameras lose the ball, if no contact comes first.
    """

    times: Floats
    surfaces: Integers
    before: Floats
    after: Floats
    lost: Floats


@dataclass(frozen=True)
class Touches:
    """What each of B balls touches, at most K times, until cameras lose it.

    Attributes:
        times: (B, K) s after the first state, infinite beyond the last.
        surfaces: (B, K) numbers of surfaces, ``NONE`` beyond the last.
        states: (B, K, 9) just after.
        gone: (B,) s after which the ball is out of sight, or its touches are not followed.
    """

    times: Floats
    surfaces: Integers
    states: Floats
    gone: Floats

    def take(self, rows: Integers) -> "Touches":
        """Return what some of the balls touch."""
        return Touches(self.times[rows], self.surfaces[rows], self.states[rows], self.gone[rows])


def touches(truth: Truth, states: Floats, most: int, random: np.random.Generator) -> Touches:
    """Follow balls through their first contacts.

    Args:
        truth: the hall's physics.
        states: (B, 9) states to start from.
        most: contacts followed a ball (K).
        random: where the scatter of the bounces comes from.
    """
    count = len(states)
    times, gone = np.full((count, most), np.inf), np.zeros(count)
    surfaces, after = np.full((count, most), NONE), np.full((count, most, STATE_SIZE), np.nan)
    going, now, current = np.arange(count), np.zeros(count), states
    for k in range(most + 1):
        arcs = arcs_from(truth, current)
        gone[going] = now + np.minimum(arcs.times, arcs.lost)
        on = (arcs.times < arcs.lost) & (k < most)
        if not on.any():
            break
        current = _scattered(truth, arcs, random)[on]
        going, now = going[on], (now + arcs.times)[on]
        times[going, k], surfaces[going, k], after[going, k] = now, arcs.surfaces[on], current
    return Touches(times, surfaces, after, gone)


def arcs_from(truth: Truth, states: Floats) -> Arcs:
    """Fly (B, 9) states to their next contacts."""
    looks = np.arange(0.0, LONGEST_ARC, LOOK)
    flight = truth.simulator.fly(states, looks)
    met = flight.contacts
    times = np.where(met.count > 0, met.time[:, 0], np.inf)
    floor, on_floor = _floor(truth, flight.states, looks)
    first = floor < times
    times = np.where(first, floor, times)
    away = ~in_sight(flight.states) & (looks < times[:, None])
    return Arcs(
        times,
        np.where(first, FLOOR_SURFACE, met.surface[:, 0]),
        np.where(first[:, None], on_floor, met.before[:, 0]),
        np.where(first[:, None], floor_bounced(on_floor), met.after[:, 0]),
        np.where(away.any(axis=1), looks[np.maximum(away.argmax(axis=1) - 1, 0)], LONGEST_ARC),
    )


def _scattered(truth: Truth, arcs: Arcs, random: np.random.Generator) -> Floats:
    after, bounced = arcs.after.copy(), arcs.surfaces == TABLE
    before = arcs.before[bounced]
    after[bounced] = truth.scatter.deviated(truth.simulator, before, after[bounced], random)
    return after


def _floor(truth: Truth, paths: Floats, looks: Floats) -> tuple[Floats, Floats]:
    """Return when balls meet the floor (infinite: not) and their states there (Newton)."""
    level = FLOOR + BALL_RADIUS
    below = (paths[..., 2] < level) & (paths[..., 5] < 0)
    falls = below.any(axis=1)
    last = np.maximum(below.argmax(axis=1) - 1, 0)
    start = paths[np.arange(len(paths)), last]
    state, passed = start.copy(), np.zeros(len(paths))
    for _ in range(4):
        speed = np.minimum(state[:, 5], -1e-3)
        passed = np.clip(passed + (level - state[:, 2]) / speed, 0.0, LOOK)
        state[falls] = truth.simulator.fly(start[falls], passed[falls, None]).states[:, 0]
    return np.where(falls, looks[last] + passed, np.inf), state
