"""The umpire: what the contacts of a ball mean by the rules.

Deviation from the rules: a serve that touches the net and lands is played on, not repeated.
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from models.arena.contacts import Touches
from models.ball.contact_laws import NET, NONE, TABLE

Floats = NDArray[np.float64]
Integers = NDArray[np.int64]
Booleans = NDArray[np.bool_]


@dataclass(frozen=True)
class Call:
    """What became of B strokes.

    Attributes:
        good: (B,) whether the ball landed on the other side, as it must.
        landing: (B,) number of the touch that decided.
        decided: (B,) s after the stroke at which a faulty stroke ends the point.
        fault: (B,) ``net`` or ``out``, of faulty strokes.
    """

    good: Booleans
    landing: Integers
    decided: Floats
    fault: NDArray[np.str_]


def called(flight: Touches, ways: Floats, serve: bool) -> Call:
    """Judge what (B,) strokes towards ``ways`` touched first."""
    rows, order = np.arange(len(ways)), np.arange(flight.times.shape[1])
    lengths = flight.states[..., 1] * ways[:, None]
    on_top = (flight.surfaces == TABLE) & (flight.states[..., 2] > 0)
    net = flight.surfaces == NET
    allowed = net.copy()
    if serve:
        allowed[:, 0] = on_top[:, 0] & (lengths[:, 0] < 0)
    landing = np.where(allowed.all(axis=1), order[-1], (~allowed).argmax(axis=1))
    good = on_top[rows, landing] & (lengths[rows, landing] > 0)
    if serve:
        good &= allowed[:, 0]
    netted = (net & (order <= landing[:, None])).any(axis=1)
    decided = np.minimum(flight.times[rows, landing], flight.gone)
    return Call(good, landing, decided, np.where(netted, "net", "out"))


def lost_by(flight: Touches, landing: Integers) -> tuple[Floats, NDArray[np.str_]]:
    """Return when balls that nobody returned ended the point, and how."""
    time, surface = after_landing(flight, landing)
    return time, np.where(surface == TABLE, "double_bounce", "missed")


def after_landing(flight: Touches, landing: Integers) -> tuple[Floats, Integers]:
    """Return when balls are lost after their landing, and which surface they then touch."""
    rows, last = np.arange(len(landing)), flight.times.shape[1] - 1
    following = np.minimum(landing + 1, last)
    beyond = landing >= last
    time = np.where(beyond, np.inf, flight.times[rows, following])
    surface = np.where(beyond, NONE, flight.surfaces[rows, following])
    return np.minimum(time, flight.gone), surface
