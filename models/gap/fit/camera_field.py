"""The smooth position-dependent camera error: a Gaussian field that all shots share.

Every calibration leaves a position error that is a smooth function of place. It is a Gaussian field
written as a sum of its first Karhunen-Loeve functions. Their coefficients, of unit variance, are
random effects: R for each axis, common to all shots, integrated out wherever hypotheses are tested
(shared_errors.py).
"""

from dataclasses import dataclass, replace

import numpy as np
from scipy.spatial.distance import cdist

from rallygap.models.ball.camera_field import covariance, weighted_covariances
from rallygap.models.ball.types import Floats
from rallygap.models.gap.fit.shots import Shots, spread_evenly
from rallygap.models.gap.settings import FieldSettings


@dataclass(frozen=True)
class CameraField:
    """Karhunen-Loeve functions of a Gaussian field over measured places.

    Attributes:
        nodes: (M, 3) m, places that represent the measured ones.
        weights: (M, R) of the covariances with the nodes in each function.
        size: m, standard deviation of a coordinate's error.
        settings: of the field.
    """

    nodes: Floats
    weights: Floats
    size: float
    settings: FieldSettings

    @classmethod
    def over(cls, shots: Shots, settings: FieldSettings, size: float) -> "CameraField":
        """Return the functions of a field of a size over the places where balls were measured."""
        nodes = _spread_nodes(shots.positions[shots.valid], settings)
        values, vectors = np.linalg.eigh(covariance(nodes, nodes, settings.length))
        order = np.argsort(values)[::-1]
        values, vectors = values[order], vectors[:, order]
        share = np.cumsum(values) / values.sum()
        rank = int(np.searchsorted(share, settings.variance_share)) + 1
        return cls(nodes, vectors[:, :rank] / np.sqrt(values[:rank]), size, settings)

    def functions(self, places: Floats) -> Floats:
        """Return (..., R) values of the functions at (..., 3) places, m."""
        length = self.settings.length
        sums = weighted_covariances(places.reshape(-1, 3), self.nodes, self.weights, length)
        functions: Floats = self.size * sums.reshape(*places.shape[:-1], -1)
        return functions

    def on(self, shots: Shots, places: Floats) -> Shots:
        """Return shots that have these functions as shared errors, at (B, N, 3) places.

        To estimate coefficients, give the fitted places: those measured are correlated with their
        own errors, which would pass for a field.
        """
        return replace(shots, shared=self.functions(places))

    def node_weights(self, coefficients: Floats) -> Floats:
        """Return (M, 3) weights of the nodes of the field with (3 R,) coefficients, m."""
        weights: Floats = self.size * self.weights @ coefficients.reshape(3, -1).T
        return weights


def _spread_nodes(places: Floats, settings: FieldSettings) -> Floats:
    """Return (M, 3) of (N, 3) places, each the farthest from those before it."""
    some = places[spread_evenly(len(places), settings.places)]
    far = np.linalg.norm(some - np.median(some, axis=0), axis=1)
    some = some[far <= np.quantile(far, settings.inner_places)]  # outliers are far from all others
    chosen = [int(np.argmin(np.linalg.norm(some - some.mean(axis=0), axis=1)))]
    distance = cdist(some, some[chosen])[:, 0]
    for _ in range(min(settings.nodes, len(some)) - 1):
        chosen.append(int(distance.argmax()))
        distance = np.minimum(distance, cdist(some, some[chosen[-1:]])[:, 0])
    nodes: Floats = some[chosen]
    return nodes
