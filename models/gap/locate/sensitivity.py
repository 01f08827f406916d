"""Sensitivity of a ball's path to its state: propagators, arc by arc (variational equations).

To first order the change ``z`` of a state follows ``dz/dt = J z + f`` with the forcing f. Its
propagator comes from exact flights from states nearby, so that whatever the simulator does is in
it. It is taken from one bounce to the next, since a bounce that rolls forgets part of the spin and
cannot be undone; beyond a bounce, flights from before it carry on.
"""

from dataclasses import dataclass

import numpy as np

from models.ball.simulator import Simulator
from models.ball.state import STATE_SIZE
from models.ball.types import Floats
from models.gap.fit.measurement import KINK, STATE_STEPS
from models.gap.fit.trajectory import KICK_SIZE, apply_kicks, first_bounce
from models.gap.types import Bools, Indices

# Of states nearby, that a flight may shrink to: where some have bounced and rolled it is none.
LEAST_VOLUME = 1e-3


@dataclass(frozen=True)
class Arc:
    """One arc of some balls, from its start to their next bounce.

    Attributes:
        rows: (R,) which balls.
        inside: (R, T) which moments are within it.
        beyond: (R, T) which are after it.
        steps: (R, T) s from the moment before, or from the start of the arc; zero outside.
        states: (R, T, 9) of the balls.
        propagator: (R, T, 9, 9) changes of the states by that at the start, bounces included.
    """

    rows: Indices
    inside: Bools
    beyond: Bools
    steps: Floats
    states: Floats
    propagator: Floats


def arcs(simulator: Simulator, nuisance: Floats, times: Floats) -> list[Arc]:
    """Return the arcs of balls of (B, 9 + 3 K) unknowns, looked at (B, T) s after their start."""
    found: list[Arc] = []
    rows, start = np.arange(len(times)), np.zeros(len(times))
    states, number = nuisance[:, :STATE_SIZE], 0
    while len(rows):
        since = times[rows] - start[:, None]
        flight = simulator.fly(states, np.maximum(since, 0.0))
        bounced, moment, before, after = first_bounce(flight)
        end = np.full(len(rows), np.inf)
        end[bounced] = moment
        found.append(_arc(simulator, states, rows, since, end, flight.states))
        place = STATE_SIZE + KICK_SIZE * number
        states = after
        if place < nuisance.shape[1]:
            states = apply_kicks(before, after, nuisance[rows[bounced], place : place + KICK_SIZE])
        rows, start, number = rows[bounced], start[bounced] + moment, number + 1
    return found


def _arc(
    simulator: Simulator,
    start: Floats,
    rows: Indices,
    since: Floats,
    end: Floats,
    states: Floats,
) -> Arc:
    shifted = (start + np.diag(STATE_STEPS)[:, None]).reshape(-1, STATE_SIZE)
    looks = np.tile(np.maximum(since, 0.0), (STATE_SIZE, 1))
    ahead = simulator.fly(shifted, looks).states.reshape(STATE_SIZE, *states.shape)
    propagator = np.moveaxis(ahead - states, 0, -1) / STATE_STEPS
    # So near the bounce that a ball from nearby may have bounced, nothing is asked.
    inside = (since >= 0.0) & (since < end[:, None] - KINK)
    clock = np.clip(since, 0.0, end[:, None])
    steps = np.diff(clock, axis=1, prepend=0.0)
    return Arc(rows, inside, since >= end[:, None], steps, states, propagator)
