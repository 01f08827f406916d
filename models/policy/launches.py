"""Launches: random balls struck at the far end that the robot can play.

Drawn independently and uniformly unless said otherwise:

- position: x in `STRUCK_ACROSS`, y in `STRUCK_ALONG`, z in `STRUCK_HEIGHT`: from a serve just after
  its bounce on the far half to a loop from behind the table;
- speed: log-uniform in `SPEED`, so half of the balls are under 6.9 m/s;
- spin: about the horizontal axis across the flight in `TOPSPIN` (negative is backspin), about the
  vertical in `SIDESPIN`, about the direction of flight in `CORKSCREW`;
- target of the bounce: x in `BOUNCE_ACROSS`, y in `BOUNCE_ALONG`. The elevation is roughly that of
  the flat arc to it in the literature's air, whichever simulator flies the ball. So all simulators
  are offered the same strokes and differ only in those they reject.

A stroke is kept if in the simulator the ball clears the net, first bounces on the robot's half,
and then, while in play, passes a point of `WORKSPACE` that the racket reaches by then from neutral.
About half of the strokes are rejected: slow ones that fall short, fast ones that fly long or wide.
"""

import numpy as np

from rallygap.models.ball.simulator import Simulator
from rallygap.models.ball.state import (
    BALL_RADIUS,
    DRAG_FACTOR,
    MAGNUS_FACTOR,
    NET_HEIGHT,
    POSITION,
    SPIN,
    STATE_SIZE,
    VELOCITY,
)
from rallygap.models.ball.types import Bools, Floats
from rallygap.models.policy.incoming_balls import MAX_DURATION, playable

STRUCK_ACROSS = (-0.5, 0.5)  # m
STRUCK_ALONG = (0.6, 2.2)  # m
STRUCK_HEIGHT = (0.03, 0.50)  # m
SPEED = (4.0, 12.0)  # m/s
TOPSPIN = (-100.0, 250.0)  # rad/s
SIDESPIN = (-100.0, 100.0)  # rad/s
CORKSCREW = (-50.0, 50.0)  # rad/s
BOUNCE_ACROSS = (-0.5, 0.5)  # m
BOUNCE_ALONG = (-1.3, -0.3)  # m

# Where the racket strikes well, before the arm is fully stretched (m).
WORKSPACE = np.array([[-0.65, 0.65], [-2.0, -1.5], [0.08, 0.5]])
RACKET_HOME = np.array([0.0, -1.64, 0.30])  # m
RACKET_SPEED = np.array([2.0, 1.2, 1.6])  # m/s across, along, up: 80 % of its largest command
SLOW_START = 0.1  # s lost to inertia

# The literature's air (Nakashima 2010), for aiming only.
GRAVITY = 9.81  # m/s^2
DRAG = 0.54 * DRAG_FACTOR  # 1/m
LIFT = 0.069 * MAGNUS_FACTOR

FLIGHT_TIMES = np.arange(0.0, MAX_DURATION + 0.005, 0.010)  # s; 16 cm of the fastest ball
MOST_TRIED = 1024  # strokes at once, which fit a processor's cache
FEWEST_KEPT = 0.02  # share of the strokes tried, below which the simulator is rejected


def draw_launches(simulator: Simulator, count: int, random: np.random.Generator) -> Floats:
    """Return (count, 9) launch states of balls that the robot can play under ``simulator``.

    Raises:
        ValueError: fewer than ``FEWEST_KEPT`` of the strokes can be played in this simulator.
    """
    kept = np.empty((0, STATE_SIZE))
    tried = 0
    while len(kept) < count:
        strokes = draw_strokes(min(32 + 4 * (count - len(kept)), MOST_TRIED), random)
        kept = np.concatenate([kept, strokes[is_playable(simulator, strokes)]])
        tried += len(strokes)
        if tried >= MOST_TRIED and len(kept) < FEWEST_KEPT * tried:
            raise ValueError("hardly any stroke lands where the robot could play it: check drag")
    return kept[:count]


def draw_strokes(count: int, random: np.random.Generator) -> Floats:
    """Return (count, 9) launch states of the documented distribution, before rejection."""
    ranges = (STRUCK_ACROSS, STRUCK_ALONG, STRUCK_HEIGHT, BOUNCE_ACROSS, BOUNCE_ALONG)
    drawn = np.stack([random.uniform(*limits, size=count) for limits in ranges], axis=1)
    struck, targets = drawn[:, :3], drawn[:, 3:]
    speed = SPEED[0] * (SPEED[1] / SPEED[0]) ** random.random(count)
    spins = np.stack([random.uniform(*s, size=count) for s in (TOPSPIN, SIDESPIN, CORKSCREW)])
    way = np.column_stack([targets - struck[:, :2], np.zeros(count)])
    distance = np.linalg.norm(way, axis=1)
    ahead = way / distance[:, None]
    across = np.cross([0.0, 0.0, 1.0], ahead)
    slope = _flat_slope(distance, BALL_RADIUS - struck[:, 2], speed, spins[0])[:, None]
    direction = (ahead + slope * [0.0, 0.0, 1.0]) / np.hypot(1.0, slope)
    strokes = np.empty((count, STATE_SIZE))
    strokes[:, POSITION] = struck
    strokes[:, VELOCITY] = speed[:, None] * direction
    axes = np.stack([across, np.broadcast_to([0.0, 0.0, 1.0], ahead.shape), direction])
    strokes[:, SPIN] = np.einsum("kb,kbi->bi", spins, axes)
    return strokes


def is_playable(simulator: Simulator, launches: Floats) -> Bools:
    """Return which of (B, 9) launches the robot can play under ``simulator``."""
    flight = simulator.fly(launches, FLIGHT_TIMES)
    between = playable(flight, FLIGHT_TIMES)
    passed = _over_net(flight.states) & np.isfinite(between[:, 0])
    fair = np.zeros(len(launches), dtype=bool)
    fair[passed] = _in_reach(flight.states[passed], between[passed])
    return fair


def _flat_slope(distance: Floats, rise: Floats, speed: Floats, topspin: Floats) -> Floats:
    """Return the slope of the flatter of two arcs that end ``distance`` ahead, ``rise`` above.

    A parabola with gravity and Magnus force acting over the flight time that drag lengthens. Where
    the speed is too small, the slope that reaches furthest.
    """
    longer = np.expm1(DRAG * distance) / (DRAG * distance)
    drop = 0.5 * (GRAVITY + LIFT * topspin * speed) * (distance * longer / speed) ** 2
    # rise = distance * slope - drop * (1 + slope^2)
    discriminant = distance**2 - 4 * drop * (drop + rise)
    flat = 2 * (drop + rise) / (distance + np.sqrt(np.maximum(discriminant, 0.0)))
    furthest = 1 / np.sqrt(1 - 4 * drop * rise / distance**2)
    return np.where(discriminant < 0.0, furthest, flat)


def _over_net(paths: Floats) -> Bools:
    """Return which (B, T, 9) paths cross the net's plane above the net."""
    y, z = paths[..., 1], paths[..., 2]
    rows, behind = np.arange(len(paths)), np.maximum((y < 0).argmax(axis=1), 1)
    y0, y1, z0, z1 = y[rows, behind - 1], y[rows, behind], z[rows, behind - 1], z[rows, behind]
    crosses = (y0 >= 0) & (y1 < 0)
    height = z0 + (z1 - z0) * y0 / np.where(crosses, y0 - y1, 1.0)
    return crosses & (height > NET_HEIGHT + BALL_RADIUS)


def _in_reach(paths: Floats, between: Floats) -> Bools:
    """Return which (B, T, 9) paths pass a point that the racket can reach by then.

    Args:
        paths: true states at ``FLIGHT_TIMES``.
        between: (B, 2) s, bounce and end of play.
    """
    positions = paths[..., POSITION]
    travel = RACKET_SPEED * np.maximum(FLIGHT_TIMES - SLOW_START, 0.0)[:, None]
    lower = np.maximum(WORKSPACE[:, 0], RACKET_HOME - travel)
    upper = np.minimum(WORKSPACE[:, 1], RACKET_HOME + travel)
    inside = ((lower <= positions) & (positions <= upper)).all(axis=2)
    bounced, gone = between[:, :1] < FLIGHT_TIMES, between[:, 1:] <= FLIGHT_TIMES
    return (inside & bounced & ~gone).any(axis=1)
