"""Decisions of the umpire, from the contacts of the ball.

Deviation from the rules: after a serve that touches the net and lands, play goes on.
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from rallygap.models.arena.contacts import ContactSequence
from rallygap.models.ball.contact_laws import NET, NONE, TABLE
from rallygap.models.ball.types import Bools, Floats, Integers


@dataclass(frozen=True)
class Ruling:
    """The outcome of B strokes."""

    good: Bools  # (B,) whether the ball landed on the opponent's side
    landing: Integers  # (B,) index of the deciding contact
    decided: Floats  # (B,) s after the stroke at which a faulty stroke ends the point
    fault: NDArray[np.str_]  # (B,) net or out, of faulty strokes


def judge_strokes(flight: ContactSequence, directions: Floats, serve: bool) -> Ruling:
    """Judge strokes towards (B,) ``directions`` by their first contacts."""
    rows, order = np.arange(len(directions)), np.arange(flight.times.shape[1])
    lengths = flight.states[..., 1] * directions[:, None]
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
    decided = np.minimum(flight.times[rows, landing], flight.last_visible)
    return Ruling(good, landing, decided, np.where(netted, "net", "out"))


def after_landing(flight: ContactSequence, landing: Integers) -> tuple[Floats, Integers]:
    """Return when balls are lost after their landing (B,) s, and the surface touched then."""
    rows, last = np.arange(len(landing)), flight.times.shape[1] - 1
    following = np.minimum(landing + 1, last)
    beyond = landing >= last
    time = np.where(beyond, np.inf, flight.times[rows, following])
    surface = np.where(beyond, NONE, flight.surfaces[rows, following])
    return np.minimum(time, flight.last_visible), surface
