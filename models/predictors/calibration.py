"""Prediction regions of a given coverage: split conformal prediction of positions.

A predictor's covariance gives an ellipsoid its shape; how large it has to be for a given coverage
follows from the errors on validation windows (Vovk, Gammerman and Shafer 2005; Lei 2018), at every
horizon on its own.
"""

from dataclasses import dataclass

import numpy as np
from scipy.special import erf

from rallygap.models.ball.state import POSITION
from rallygap.models.predictors.errors import deviations
from rallygap.models.predictors.protocol import Floats, Forecast
from rallygap.models.predictors.windows import Windows

LEVELS = (0.5, 0.9)
NORMAL_MEDIAN = 1.538  # radius that contains half of a normal distribution in three dimensions


@dataclass(frozen=True)
class Errors:
    """Position errors of B forecasts at H horizons, NaN where nothing was measured.

    Attributes:
        away: (B, H, 3) m, forecast less measured.
        covariances: (B, H, 3, 3) m^2, what the predictor says of them.
    """

    away: Floats
    covariances: Floats

    @classmethod
    def of(cls, forecast: Forecast, covariances: Floats, windows: Windows) -> "Errors":
        """Return the errors of forecasts of windows."""
        return cls(deviations(forecast, windows, POSITION), covariances)

    @property
    def distances(self) -> Floats:
        """(B, H) Mahalanobis distances."""
        solved = np.linalg.solve(self.covariances, self.away[..., None])[..., 0]
        return np.sqrt((self.away * solved).sum(axis=-1))


@dataclass(frozen=True)
class Calibration:
    """Radii of ellipsoids.

    Attributes:
        radii: (L, H) in Mahalanobis distances, by level and horizon.
    """

    radii: Floats

    @classmethod
    def of(cls, validation: Errors) -> "Calibration":
        """Return the smallest radii whose ellipsoids cover as much as ``LEVELS`` say.

        Where too few windows are measured for a level, they are NaN.
        """
        distances = np.sort(validation.distances, axis=0)  # NaN is last
        counts = np.isfinite(distances).sum(axis=0)
        radii = np.full((len(LEVELS), distances.shape[1]), np.nan)
        for row, level in zip(radii, LEVELS, strict=True):
            indices = np.ceil((counts + 1) * level).astype(int) - 1
            enough = (counts > 0) & (indices < counts)
            columns = np.flatnonzero(enough)
            row[columns] = distances[indices[columns], columns]
        return cls(radii)

    def covered(self, errors: Errors) -> Floats:
        """Return (L, B, H) 1 where a region contains the measured position.

        They are NaN where there is no region, or no measurement.
        """
        away = errors.distances - self.radii[:, None]
        return np.where(np.isfinite(away), away <= 0.0, np.nan)

    def sizes(self, errors: Errors) -> Floats:
        """Return (L, B, H) radii, m, of balls with the volumes of the regions."""
        volumes = np.linalg.det(errors.covariances) ** (1 / 6)
        return self.radii[:, None] * volumes


def crps(errors: Errors, calibration: Calibration) -> Floats:
    """Return (B, H) continuous ranked probability scores of positions, m, mean over the axes.

    Of a normal distribution (Gneiting 2005) whose covariance is scaled so that half of the
    validation errors are in its inner half.
    """
    scale = calibration.radii[LEVELS.index(0.5)] / NORMAL_MEDIAN
    size = scale[:, None] * np.sqrt(np.diagonal(errors.covariances, axis1=2, axis2=3))
    z = errors.away / size
    density = np.exp(-0.5 * z**2) / np.sqrt(2 * np.pi)
    scores = size * (z * erf(z / np.sqrt(2)) + 2 * density - 1 / np.sqrt(np.pi))
    return scores.mean(axis=2)
