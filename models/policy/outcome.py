"""Outcomes of strokes: where the ball flies after the racket, and whether it is a return."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from rallygap.models.arena.contacts import ContactSequence
from rallygap.models.arena.umpire import judge_strokes
from rallygap.models.ball.simulator import Simulator
from rallygap.models.ball.state import BALL_RADIUS, VELOCITY
from rallygap.models.ball.types import Bools, Floats
from rallygap.models.policy.goals import Goals

# For simulators that do not list a net; a return has to pass one.
NET = {"restitution": 0.2, "friction": 0.5}
LONGEST_FLIGHT = 2.5  # s; a ball lobbed 7 m high is down by then
SAMPLE_TIMES = np.arange(0.0, LONGEST_FLIGHT, 0.01)  # s; chords deviate from the arc by 0.1 mm


@dataclass(frozen=True)
class Outcome:
    """Outcomes of B strokes.

    Attributes:
        returned: (B,) whether the ball first touched the far half, perhaps after the net cord.
        fault: (B,) ``net`` or ``out``; empty for a return.
        before_landing: (B, 9) state just before a return lands; NaN for other balls.
        landing: (B, 2) m where it landed; for a ball that is no return, where it would come down
            without a net and on an infinite table.
        distance: (B,) m from there to the goal.
        net_height: (B,) m of the ball's centre above the table as it passes the net's plane, or
            would pass it.
        speed: (B,) m/s just after the racket.
        topspin: (B,) rad/s just after the racket; negative is backspin.
    """

    returned: Bools
    fault: NDArray[np.str_]
    before_landing: Floats
    landing: Floats
    distance: Floats
    net_height: Floats
    speed: Floats
    topspin: Floats


def judge(simulator: Simulator, after: Floats, goals: Goals) -> Outcome:
    """Fly (B, 9) balls on from the racket, with a net in any case, and apply the rules."""
    met = with_net(simulator).fly(after, [LONGEST_FLIGHT]).contacts
    ends = np.full(len(after), LONGEST_FLIGHT)
    times = np.where(np.isnan(met.time), np.inf, met.time)
    touches = ContactSequence(times, met.surface, met.after, ends)
    call = judge_strokes(touches, np.ones(len(after)), serve=False)
    touched = met.before[np.arange(len(after)), call.landing]
    # Without a net and on an infinite table.
    paths = simulator.without_surfaces().fly(after, SAMPLE_TIMES).states
    above, rising = paths[..., 2] - BALL_RADIUS, paths[..., 5] >= 0
    down = _zero_crossing(paths, np.where(rising, 1.0, above))
    landing = np.where(call.good[:, None], touched[:, :2], down[:, :2])
    return Outcome(
        returned=call.good,
        fault=np.where(call.good, "", call.fault),
        before_landing=np.where(call.good[:, None], touched, np.nan),
        landing=landing,
        distance=goals.distance(landing),
        net_height=_zero_crossing(paths, -paths[..., 1])[:, 2],
        speed=np.linalg.norm(after[:, VELOCITY], axis=1),
        topspin=topspin(after),
    )


def with_net(simulator: Simulator) -> Simulator:
    """Return the simulator with a net on its table."""
    return simulator if "net" in simulator.effects else simulator.amended("net", **NET)


def topspin(states: Floats) -> Floats:
    """Return the topspin of (B, 9) balls, rad/s; negative is backspin."""
    _, _, _, vx, vy, _, wx, wy, _ = states.T
    along = np.maximum(np.hypot(vx, vy), 1e-9)
    return (wy * vx - wx * vy) / along


def _zero_crossing(paths: Floats, values: Floats) -> Floats:
    """Return the (B, 3) positions at which ``values`` (B, T) fall to zero, or the last ones."""
    passed = values <= 0
    last = values.shape[1] - 1
    k = np.where(passed.any(axis=1), np.maximum(passed.argmax(axis=1), 1), last)
    rows = np.arange(len(paths))
    before, after = values[rows, k - 1], values[rows, k]
    share = np.divide(before, before - after, out=np.zeros(len(paths)), where=before > after)
    start, end = paths[rows, k - 1, :3], paths[rows, k, :3]
    return start + np.clip(share, 0, 1)[:, None] * (end - start)
