"""Propagation of perturbations: later changes of a ball's state by a force or a jump.

To first order the change ``z`` of a state follows ``dz/dt = J z + f`` with the forcing f. Its
propagator comes from exact flights from states nearby, from one bounce to the next, since a bounce
that rolls forgets part of the spin and cannot be inverted; beyond a bounce, the flights go on.
"""

from dataclasses import dataclass

import numpy as np

from rallygap.models.ball.simulator import Simulator
from rallygap.models.ball.state import STATE_SIZE
from rallygap.models.ball.types import Floats
from rallygap.models.gap.fit.measurement import KINK, STATE_STEPS
from rallygap.models.gap.fit.trajectory import KICK_SIZE, apply_kicks, first_bounce
from rallygap.models.gap.types import Bools, Indices

# Least volume of propagated states: where some have bounced and rolled there is no inverse.
LEAST_VOLUME = 1e-3


@dataclass(frozen=True)
class Arc:
    """One arc of some balls, from its start to their next bounce.

    Attributes:
        rows: (R,) which balls.
        inside: (R, T) which times are within it.
        beyond: (R, T) which are after it.
        steps: (R, T) s from the time before, or from the start of the arc; zero outside.
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
    """Return the arcs of balls of (B, 9 + 3 K) nuisance parameters at (B, T) s from their start."""
    found: list[Arc] = []
    rows, start = np.arange(len(times)), np.zeros(len(times))
    states, number = nuisance[:, :STATE_SIZE], 0
    while len(rows):
        since = times[rows] - start[:, None]
        flight = simulator.fly(states, np.maximum(since, 0.0))
        bounced, time, before, after = first_bounce(flight)
        end = np.full(len(rows), np.inf)
        end[bounced] = time
        found.append(_arc(simulator, states, rows, since, end, flight.states))
        place = STATE_SIZE + KICK_SIZE * number
        states = after
        if place < nuisance.shape[1]:
            states = apply_kicks(before, after, nuisance[rows[bounced], place : place + KICK_SIZE])
        rows, start, number = rows[bounced], start[bounced] + time, number + 1
    return found


def _arc(
    simulator: Simulator, start: Floats, rows: Indices, since: Floats, end: Floats, states: Floats
) -> Arc:
    shifted = (start + np.diag(STATE_STEPS)[:, None]).reshape(-1, STATE_SIZE)
    times = np.tile(np.maximum(since, 0.0), (STATE_SIZE, 1))
    ahead = simulator.fly(shifted, times).states.reshape(STATE_SIZE, *states.shape)
    propagator = np.moveaxis(ahead - states, 0, -1) / STATE_STEPS
    # Times so near the bounce that a ball from nearby may have bounced are outside.
    inside = (since >= 0.0) & (since < end[:, None] - KINK)
    clock = np.clip(since, 0.0, end[:, None])
    steps = np.diff(clock, axis=1, prepend=0.0)
    return Arc(rows, inside, since >= end[:, None], steps, states, propagator)


def after_forcing(arcs: list[Arc], forcing: Floats) -> Floats:
    """Return the (B, T, 9, D) changes of states by (B, T, 9, D) rates of change."""
    changes = np.zeros(forcing.shape)
    for arc in arcs:
        kept = arc.inside & (np.abs(np.linalg.det(arc.propagator)) > LEAST_VOLUME)
        propagator = np.where(kept[..., None, None], arc.propagator, np.eye(STATE_SIZE))
        rate = np.linalg.solve(propagator, forcing[arc.rows])
        rate = np.where(kept[..., None, None], rate, 0.0)
        # The trapezoid; before the first time of an arc its rate is that at this time.
        last = np.concatenate([rate[:, :1], rate[:, :-1]], axis=1)
        last = np.where(np.roll(kept, 1, axis=1)[..., None, None], last, rate)
        source = np.cumsum(arc.steps[..., None, None] * (rate + last) / 2, axis=1)
        changes[arc.rows] += _later(arc, source)
    return changes


def after_jump(arcs: list[Arc], number: int, jumps: Floats, count: int) -> Floats:
    """Return the (B, T, 9, D) changes of states, at T times, by jumps after a bounce.

    Args:
        arcs: of the balls.
        number: of the bounce, 0 for the first.
        jumps: (B, 9, D) of the state.
        count: T, of times.
    """
    changes = np.zeros((len(jumps), count, *jumps.shape[1:]))
    if number + 1 < len(arcs):
        arc = arcs[number + 1]
        changes[arc.rows] = _later(arc, jumps[arc.rows][:, None])
    return changes


def _later(arc: Arc, source: Floats) -> Floats:
    """Return the later effects of changes at the start of an arc, (R, T or 1, 9, D)."""
    reached = (arc.inside | arc.beyond)[..., None, None]
    later: Floats = np.where(reached, arc.propagator @ source, 0.0)
    return later
