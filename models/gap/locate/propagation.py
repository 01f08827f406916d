"""Propagation of perturbations: later changes of a ball's state by a force or a jump.

To first order the change ``z`` of a state follows ``dz/dt = J z + f`` with the forcing f, and is
propagated by each arc (sensitivity.py).
"""

import numpy as np

from models.ball.state import STATE_SIZE
from models.ball.types import Floats
from models.gap.locate.sensitivity import LEAST_VOLUME, Arc


def after_forcing(arcs: list[Arc], forcing: Floats) -> Floats:
    """Return the (B, T, 9, D) changes of states by D forcings.

    Args:
        arcs: of the balls.
        forcing: (B, T, 9, D) rates of change of the state.
    """
    changes = np.zeros(forcing.shape)
    for arc in arcs:
        kept = arc.inside & (np.abs(np.linalg.det(arc.propagator)) > LEAST_VOLUME)
        propagator = np.where(kept[..., None, None], arc.propagator, np.eye(STATE_SIZE))
        rate = np.linalg.solve(propagator, forcing[arc.rows])
        rate = np.where(kept[..., None, None], rate, 0.0)
        # The trapezoid; before the first moment of an arc its rate is that of this moment.
        last = np.concatenate([rate[:, :1], rate[:, :-1]], axis=1)
        last = np.where(np.roll(kept, 1, axis=1)[..., None, None], last, rate)
        source = np.cumsum(arc.steps[..., None, None] * (rate + last) / 2, axis=1)
        changes[arc.rows] += _later(arc, source)
    return changes


def after_jump(arcs: list[Arc], number: int, jumps: Floats, count: int) -> Floats:
    """Return the (B, T, 9, D) changes of states by D jumps of each state after a bounce.

    Args:
        arcs: of the balls.
        number: of the bounce, 0 for the first.
        jumps: (B, 9, D) of the state.
        count: T, of moments.
    """
    changes = np.zeros((len(jumps), count, *jumps.shape[1:]))
    if number + 1 < len(arcs):
        arc = arcs[number + 1]
        changes[arc.rows] = _later(arc, jumps[arc.rows][:, None])
    return changes


def _later(arc: Arc, source: Floats) -> Floats:
    """Return what changes at the start of an arc, (R, T or 1, 9, D), are at each moment of it."""
    reached = (arc.inside | arc.beyond)[..., None, None]
    later: Floats = np.where(reached, arc.propagator @ source, 0.0)
    return later
