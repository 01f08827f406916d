"""Free fit: what every shot says of its own departure from a simulator, with no law assumed.

Each shot gets an acceleration of its own in every arc, and at every bounce a kick and a jump in
height of its own (a surface that is elsewhere), with hardly any prior. What they do to its path is
what was measured of it, most of the noise left out.
"""

from collections.abc import Iterator
from dataclasses import replace

import numpy as np

from models.ball.simulator import Simulator
from models.ball.state import POSITION, STATE_SIZE, VELOCITY
from models.ball.types import Floats
from models.gap.fit.linearize import Linearised
from models.gap.fit.noise import grams
from models.gap.fit.refit import Refitted
from models.gap.locate.discrepancy import parting
from models.gap.locate.phase_selection import moved
from models.gap.locate.propagation import forced, struck
from models.gap.locate.sensitivity import Arc
from models.gap.locate.terms import Flown

ANY_ACCELERATION = 30.0  # m/s^2
ANY_HEIGHT = 0.1  # m
ANY_KICK = 1.0  # of the normal speed
UP = POSITION.stop - 1


def free_parting(found: Refitted, nominal: Simulator) -> Floats:
    """Return (B, N, 3) m by how much shots part from the nominal simulator's predictions.

    Args:
        found: the shots about a simulator near the nominal one.
        nominal: it.
    """
    linear = found.linear
    free, spread = _freed(linear, nominal)
    noise = replace(found.components.noise, scatter=(ANY_KICK,) * 3)
    parts = grams(free, noise, found.components.weights, np.ones(len(linear.unknowns)))
    total, size = parts.total(noise), free.positions.shape[-1] - 1
    more = np.arange(linear.own, size)
    total[:, more, more] += spread**-2.0
    change = np.linalg.solve(total[:, :size, :size], total[:, :size, -1:])[:, None]
    # The launch goes to where this fit has it; predictions know of no kick at all.
    labels = free.labels[..., -1:] - free.labels[..., :size] @ change
    change[:, 0, : linear.own, 0] += linear.unknowns
    positions = free.positions[..., STATE_SIZE:size] @ change[:, :, STATE_SIZE:]
    return parting(linear, found.components, positions, labels)[..., 0]


def _freed(linear: Linearised, nominal: Simulator) -> tuple[Linearised, Floats]:
    """Return shots with the columns of their own departures, and how far these may go."""
    flown = Flown.of(linear)
    changes = [*_accelerations(flown), *_jumps(flown)]
    ahead = flown.seen((), np.concatenate([change for change, _ in changes], axis=3))
    ahead.positions[~linear.sampled] = 0.0
    ahead.labels[~linear.labelled] = 0.0
    own, departure = linear.own, moved(linear, nominal)

    def put(columns: Floats, more: Floats) -> Floats:
        residual = columns[..., -1] + columns[..., own:-1] @ departure
        return np.concatenate([columns[..., :own], more, residual[..., None]], axis=-1)

    positions, labels = put(linear.positions, ahead.positions), put(linear.labels, ahead.labels)
    spread = np.concatenate([np.full(change.shape[3], size) for change, size in changes])
    return replace(linear, columns=(), positions=positions, labels=labels), spread


def _accelerations(flown: Flown) -> Iterator[tuple[Floats, float]]:
    """Yield (B, T, 9, 3) changes of states by accelerations in one arc, and how large they are."""
    for arc in flown.arcs:
        yield forced(flown.arcs, _within(arc, flown.states.shape)), ANY_ACCELERATION


def _within(arc: Arc, shape: tuple[int, ...]) -> Floats:
    """Return (B, T, 9, 3) unit accelerations along the frame's axes within an arc."""
    forcing = np.zeros((*shape, 3))
    forcing[arc.rows, :, VELOCITY] = arc.inside[..., None, None] * np.eye(3)
    return forcing


def _jumps(flown: Flown) -> Iterator[tuple[Floats, float]]:
    """Yield (B, T, 9, 1) changes of states by jumps upwards at one bounce, and their size."""
    jump = np.zeros((len(flown.states), STATE_SIZE, 1))
    jump[:, UP] = 1.0
    for bounce in range(len(flown.arcs) - 1):
        yield struck(flown.arcs, bounce, jump, flown.states.shape[1]), ANY_HEIGHT
