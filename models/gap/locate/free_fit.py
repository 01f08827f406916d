"""Free fit: the departure of every shot from a simulator, with no law assumed.

Each shot has a free acceleration in every arc, and at every bounce a free kick and a free jump in
height (a shifted surface), with wide priors.
"""

from collections.abc import Iterator
from dataclasses import replace

import numpy as np

from rallygap.models.ball.simulator import Simulator
from rallygap.models.ball.state import POSITION, STATE_SIZE, VELOCITY
from rallygap.models.ball.types import Floats
from rallygap.models.gap.fit.linearize import Linearised
from rallygap.models.gap.fit.noise import gram_matrices
from rallygap.models.gap.fit.refit import RefitResult
from rallygap.models.gap.locate.discrepancy import discrepancy
from rallygap.models.gap.locate.propagation import after_forcing, after_jump
from rallygap.models.gap.locate.terms import Flown
from rallygap.models.gap.settings import LocateSettings, Question

UP = POSITION.stop - 1


def free_discrepancy(fit: RefitResult, question: Question) -> Floats:
    """Return (B, N, 3) m the discrepancy of shots from the nominal simulator's predictions."""
    linear, settings = fit.linear, question.settings
    free, spread = _freed(fit, question.simulator, settings.locate)
    noise = replace(fit.noise_estimate.noise, scatter=(settings.locate.kick_prior,) * 3)
    parts = gram_matrices(free, noise, fit.noise_estimate.weights, np.ones(len(linear.nuisance)))
    total, size = parts.total(noise), free.positions.shape[-1] - 1
    more = np.arange(linear.nuisance_count, size)
    total[:, more, more] += spread**-2.0
    change = np.linalg.solve(total[:, :size, :size], total[:, :size, -1:])[:, None]
    # The launch is that of this fit; predictions have no kick.
    labels = free.labels[..., -1:] - free.labels[..., :size] @ change
    change[:, 0, : linear.nuisance_count, 0] += linear.nuisance
    positions = free.positions[..., STATE_SIZE:size] @ change[:, :, STATE_SIZE:]
    return discrepancy(linear, fit.noise_estimate, positions, labels, settings)[..., 0]


def _freed(
    fit: RefitResult, nominal: Simulator, settings: LocateSettings
) -> tuple[Linearised, Floats]:
    """Return shots with the columns of their free departures, and the priors of these."""
    linear = fit.linear
    flown = Flown.of(linear)
    changes = [
        *((change, settings.acceleration_prior) for change in _accelerations(flown)),
        *((change, settings.height_prior) for change in _jumps(flown)),
    ]
    ahead = flown.measured_changes((), np.concatenate([change for change, _ in changes], axis=3))
    ahead.positions[~linear.sampled] = 0.0
    ahead.labels[~linear.labelled] = 0.0
    nuisance_count, departure = linear.nuisance_count, linear.departures(nominal)

    def put(columns: Floats, more: Floats) -> Floats:
        residual = columns[..., -1] + columns[..., linear.of_hypotheses] @ departure
        return np.concatenate([columns[..., :nuisance_count], more, residual[..., None]], axis=-1)

    positions, labels = put(linear.positions, ahead.positions), put(linear.labels, ahead.labels)
    positions[..., -1] -= linear.positions[..., linear.of_shared] @ fit.camera_errors
    spread = np.concatenate([np.full(change.shape[3], size) for change, size in changes])
    shots = linear.shots.without_shared()
    return replace(linear, shots=shots, columns=(), positions=positions, labels=labels), spread


def _accelerations(flown: Flown) -> Iterator[Floats]:
    """Yield (B, T, 9, 3) changes of states by accelerations in one arc."""
    for arc in flown.arcs:
        forcing = np.zeros((*flown.states.shape, 3))
        forcing[arc.rows, :, VELOCITY] = arc.inside[..., None, None] * np.eye(3)
        yield after_forcing(flown.arcs, forcing)


def _jumps(flown: Flown) -> Iterator[Floats]:
    """Yield (B, T, 9, 1) changes of states by jumps upwards at one bounce."""
    jump = np.zeros((len(flown.states), STATE_SIZE, 1))
    jump[:, UP] = 1.0
    for bounce in range(len(flown.arcs) - 1):
        yield after_jump(flown.arcs, bounce, jump, flown.states.shape[1])
