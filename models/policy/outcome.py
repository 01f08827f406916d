"""Outcome: what becomes of a ball that the robot struck."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from models.arena.aim import in_air
from models.arena.contacts import Touches
from models.arena.umpire import called
from models.ball.simulator import Flight, Simulator
from models.ball.state import BALL_RADIUS, VELOCITY
from models.policy.goals import Goals

Floats = NDArray[np.float64]
Booleans = NDArray[np.bool_]

# A simulator without a net forecasts well where there is none; a return has to pass one.
NET = {"restitution": 0.2, "friction": 0.5}
LONGEST_FLIGHT = 2.5  # s; a ball lobbed 7 m high is down again
LOOKS = np.arange(0.0, LONGEST_FLIGHT, 0.01)  # s; the path's arc leaves its chords by 0.1 mm


@dataclass(frozen=True)
class Outcome:
    """What became of B balls that were struck.

    Attributes:
        returned: (B,) whether the ball first touched the far half, be it over the net cord.
        fault: (B,) ``net`` or ``out`` of balls that were not returned, else empty.
        landing: (B, 2) m where it landed; of a ball that was not returned, where it would have
            come down with no net in its way and a table without end.
        distance: (B,) m from there to the goal.
        net_height: (B,) m at which the ball's centre passes over the net's line, or would.
        speed: (B,) m/s just after the racket.
        topspin: (B,) rad/s just after the racket; negative is backspin.
    """

    returned: Booleans
    fault: NDArray[np.str_]
    landing: Floats
    distance: Floats
    net_height: Floats
    speed: Floats
    topspin: Floats


def judge(simulator: Simulator, after: Floats, goals: Goals) -> Outcome:
    """Fly balls on from the racket and judge them.

    Args:
        simulator: moves the balls; a net is set up where it has none.
        after: (B, 9) states just after the racket.
        goals: (B,) that were to be reached.
    """
    flight = with_net(simulator).fly(after, [LONGEST_FLIGHT])
    call = called(_touches(flight), np.ones(len(after)), serve=False)
    passing, falling = _unhindered(simulator, after)
    touched = flight.contacts.before[np.arange(len(after)), call.landing, :2]
    landing = np.where(call.good[:, None], touched, falling[:, :2])
    return Outcome(
        returned=call.good,
        fault=np.where(call.good, "", call.fault),
        landing=landing,
        distance=goals.distance(landing),
        net_height=passing[:, 2],
        speed=np.linalg.norm(after[:, VELOCITY], axis=1),
        topspin=topspin(after),
    )


def with_net(simulator: Simulator) -> Simulator:
    """Return the simulator with a net on its table."""
    return simulator if "net" in simulator.effects else simulator.amended("net", **NET)


def topspin(states: Floats) -> Floats:
    """Return how fast (B, 9) balls turn their upper side ahead, rad/s; negative is backspin."""
    _, _, _, vx, vy, _, wx, wy, _ = states.T
    along = np.maximum(np.hypot(vx, vy), 1e-9)
    turning: Floats = (wy * vx - wx * vy) / along
    return turning


def _touches(flight: Flight) -> Touches:
    met = flight.contacts
    times = np.where(np.isnan(met.time), np.inf, met.time)
    return Touches(times, met.surface, met.after, np.full(len(times), LONGEST_FLIGHT))


def _unhindered(simulator: Simulator, after: Floats) -> tuple[Floats, Floats]:
    """Return where balls pass over the net's line and where they come down, (B, 3) each."""
    paths = in_air(simulator).fly(after, LOOKS).states
    above = paths[..., 2] - BALL_RADIUS
    rising = paths[..., 5] >= 0
    return _reached(paths, -paths[..., 1]), _reached(paths, np.where(rising, 1.0, above))


def _reached(paths: Floats, left: Floats) -> Floats:
    """Return the (B, 3) positions at which ``left`` (B, T) falls to zero, or the last ones."""
    passed = left <= 0
    last = left.shape[1] - 1
    k = np.where(passed.any(axis=1), np.maximum(passed.argmax(axis=1), 1), last)
    rows = np.arange(len(paths))
    before, after = left[rows, k - 1], left[rows, k]
    share = np.divide(before, before - after, out=np.zeros(len(paths)), where=before > after)
    start, end = paths[rows, k - 1, :3], paths[rows, k, :3]
    reached: Floats = start + np.clip(share, 0, 1)[:, None] * (end - start)
    return reached
