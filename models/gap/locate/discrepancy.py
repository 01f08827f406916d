"""Parting: how far balls are from where they were predicted, when both started alike.

A prediction is launched from the first ``SEEN`` samples of a shot and the labels among them, as the
simulator reads them. Whatever differs from the simulator shifts this launch as well, so that only
the rest of it shows later: near fitted shots (linear.py)

    parting by F = F - G (G'WG)^-1 G'WF,    the products over the first samples alone,

with G the columns of the launch. Spins without a label are those that the whole path tells: a
prediction that does not know them would part by this alone.
"""

import numpy as np

from models.ball.state import STATE_SIZE
from models.ball.types import Floats
from models.gap.fit.horizons import SEEN, last_seen
from models.gap.fit.linearize import Linearised
from models.gap.fit.noise import prior_precision
from models.gap.fit.variance_components import Components
from models.gap.types import Bools

KNOWN = 1e-3  # rad/s, by which a spin without a label may shift
INLIER, TRUSTED = 0.5, 0.5


def parting(linear: Linearised, noise: Components, positions: Floats, labels: Floats) -> Floats:
    """Return (B, N, 3, D) by how much D changes make predictions part.

    Args:
        linear: shots, whose columns of the launch come first.
        noise: in which launches are fitted.
        positions: (B, N, 3, D) changes of positions, m.
        labels: (B, L, 3, D) changes of spin labels, in units of the fitted spin.
    """
    launch, spins = linear.positions[..., :STATE_SIZE], linear.labels[..., :STATE_SIZE]
    sizes = noise.noise
    first = linear.sampled & (np.arange(launch.shape[1]) < SEEN)
    early = first * noise.weights / sizes.position**2
    labelled = linear.labelled & (linear.shots.label_times <= last_seen(linear.shots))
    count = np.maximum(labelled.sum(axis=1, keepdims=True), 1)
    told = labelled / (sizes.label**2 + count * sizes.label_common**2)
    unlabelled = ~np.asarray(labelled.any(axis=1))
    prior = prior_precision(unlabelled, STATE_SIZE, sizes, KNOWN)
    normal = _products(launch, early, launch) + _products(spins, told, spins)
    normal += prior[..., None] * np.eye(STATE_SIZE)
    pull = _products(launch, early, positions) + _products(spins, told, labels)
    parted: Floats = positions - launch @ np.linalg.solve(normal, pull)[:, None]
    return parted


def reliable(linear: Linearised, noise: Components) -> Bools:
    """Return (B, N) samples that are used and no outliers, of shots that fit as shots do."""
    trusted = noise.trust[:, None] > TRUSTED
    usable: Bools = linear.sampled & (noise.weights > INLIER) & trusted
    return usable


def _products(left: Floats, weights: Floats, right: Floats) -> Floats:
    """Return (B, E, D) sums of weighted products of (B, N, 3, E) and (B, N, 3, D)."""
    count = len(left)
    weighted = (left * weights[..., None, None]).reshape(count, -1, left.shape[-1])
    products: Floats = np.swapaxes(weighted, 1, 2) @ right.reshape(count, -1, right.shape[-1])
    return products
