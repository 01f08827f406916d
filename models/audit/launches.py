"""Random launches: strokes and serves that clear the net and bounce well inside the table.

States are drawn at the bounce and rolled out backwards, so that most draws are accepted.
"""

from dataclasses import dataclass

import numpy as np

from rallygap.models.arena.sides import switch_frame
from rallygap.models.ball.simulator import Simulator
from rallygap.models.ball.state import (
    BALL_RADIUS,
    NET_HEIGHT,
    POSITION,
    SPIN,
    STATE_SIZE,
    TABLE_HALF_LENGTH,
    TABLE_HALF_WIDTH,
    VELOCITY,
)
from rallygap.models.ball.types import Floats

LAUNCH_SPEED = (4.0, 15.0)  # m/s
GROUND_SPEED = (2.5, 11.0)  # m/s along the table at the bounce
FALL = (1.2, 4.5)  # m/s downwards at the bounce
SERVES = 0.25  # share of the draws that bounce on the own half first, then on the other
SERVE_GROUND_SPEED = (3.5, 7.0)  # m/s
SERVE_FALL = (1.5, 3.5)  # m/s
MAXIMUM_SPIN = 400.0  # rad/s
HEADING_SPREAD = 0.15  # rad to either side
BEFORE = (0.22, 0.38)  # s of flight before the bounce
AFTER = (0.22, 0.38)  # s after it
AFTER_SERVE = (0.10, 0.20)  # s after the second bounce of a serve
LAUNCH_HEIGHT = (0.08, 1.5)  # m
FARTHEST = 3.5  # m behind the net
NET_CLEARANCE = 0.03  # m between ball and net
WELL_INSIDE = np.array([TABLE_HALF_WIDTH, TABLE_HALF_LENGTH]) - 0.06  # m, of second bounces
FLIGHT_ONLY = 0.08  # share of the shots that end before the bounce
LOWEST = -0.2  # m, where a shot ends

BATCH = 400  # states drawn at once
TIMES = 90  # of the roll-out that checks a launch
CHECKED = 0.9  # s after the bounce


@dataclass(frozen=True)
class Launches:
    """``states`` (B, 9) at time zero, and (B,) ``durations`` of the recordings in s."""

    states: Floats
    durations: Floats


def launches(
    simulator: Simulator, shots: int, directions: int, random: np.random.Generator
) -> Launches:
    """Draw launches; with two directions, half of them from the other side of the table."""
    states, before = np.empty((0, STATE_SIZE)), np.empty(0)
    while len(states) < shots:
        more, times = _drawn(simulator, random)
        states, before = np.concatenate([states, more]), np.concatenate([before, times])
    states, before = states[:shots], before[:shots]
    durations = _durations(simulator, states, before, random)
    ways = -np.ones(shots)
    if directions == 2:
        ways[random.permutation(shots)[: shots // 2]] = 1.0
    return Launches(switch_frame(states, ways), durations)


def _drawn(simulator: Simulator, random: np.random.Generator) -> tuple[Floats, Floats]:
    """Return some (n, 9) launch states towards +y and the (n,) s until they bounce."""
    bounces = _at_bounce(random)
    serves = random.random(len(bounces)) < SERVES
    bounces[serves] = _as_serves(bounces[serves], random)
    before = random.uniform(*BEFORE, len(bounces))
    times = np.linspace(-before, CHECKED, TIMES, axis=1)
    flight = simulator.fly(bounces, times)
    start, place = flight.states[:, 0], flight.states[..., POSITION]
    low = place[..., 2] < NET_HEIGHT + BALL_RADIUS + NET_CLEARANCE
    into_net = (low & (np.abs(place[..., 1]) < 0.15)).any(axis=1)
    speed, height = np.linalg.norm(start[:, VELOCITY], axis=1), start[:, 2]
    used = (speed >= LAUNCH_SPEED[0]) & (speed <= LAUNCH_SPEED[1]) & ~into_net
    used &= (height >= LAUNCH_HEIGHT[0]) & (height <= LAUNCH_HEIGHT[1])
    used &= start[:, 1] > -FARTHEST
    second = flight.contacts.before[:, 1, :2]
    used &= ~serves | ((np.abs(second) < WELL_INSIDE).all(axis=1) & (second[:, 1] > 0))
    return start[used], before[used]


def _at_bounce(random: np.random.Generator) -> Floats:
    """Return states just before a bounce on the half at y > 0."""
    states = np.empty((BATCH, STATE_SIZE))
    states[:, 0] = random.uniform(-0.6, 0.6, BATCH)
    states[:, 1] = random.uniform(0.15, 1.25, BATCH)
    states[:, 2] = BALL_RADIUS
    heading = HEADING_SPREAD * random.standard_normal(BATCH)
    ground = random.uniform(*GROUND_SPEED, BATCH)
    states[:, 3], states[:, 4] = ground * np.sin(heading), ground * np.cos(heading)
    states[:, 5] = -random.uniform(*FALL, BATCH)
    axes = random.standard_normal((BATCH, 3)) * [1.5, 1.0, 1.0]  # topspin and backspin lead
    axes /= np.linalg.norm(axes, axis=1, keepdims=True)
    states[:, SPIN] = axes * random.uniform(0.0, MAXIMUM_SPIN, (BATCH, 1))
    return states


def _as_serves(states: Floats, random: np.random.Generator) -> Floats:
    """Return the states of serves: moved to the half at y < 0, and slower."""
    serves = states.copy()
    serves[:, 1] -= TABLE_HALF_LENGTH
    ground = np.linalg.norm(states[:, 3:5], axis=1, keepdims=True)
    serves[:, 3:5] *= random.uniform(*SERVE_GROUND_SPEED, (len(states), 1)) / ground
    serves[:, 5] = -random.uniform(*SERVE_FALL, len(states))
    return serves


def _durations(
    simulator: Simulator, states: Floats, before: Floats, random: np.random.Generator
) -> Floats:
    """Return (B,) s of recording: mostly until well after one bounce, serves after two."""
    times = np.linspace(0.0, 1.5, 150)
    flight = simulator.fly(states, times)
    second, third = np.nan_to_num(flight.contacts.time[:, 1:3], nan=np.inf).T
    serves = flight.contacts.before[:, 0, 1] < 0
    once = np.minimum(before + random.uniform(*AFTER, len(states)), second - 0.01)
    twice = np.minimum(second + random.uniform(*AFTER_SERVE, len(states)), third - 0.01)
    durations = np.where(serves, twice, once)
    gone = np.where(flight.states[..., 2] < LOWEST, times, np.inf).min(axis=1)
    early = before - random.uniform(0.01, 0.05, len(states))
    flight_only = random.random(len(states)) < FLIGHT_ONLY
    return np.where(flight_only, early, np.minimum(durations, gone))
