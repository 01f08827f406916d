"""Forecast errors over the horizon: the norm of forecast minus measured state, and statistics."""

import warnings
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from rallygap.models.ball.state import POSITION, SPIN, VELOCITY
from rallygap.models.predictors.protocol import FUTURE_TIMES, Bools, Floats, Forecast
from rallygap.models.predictors.windows import Windows
from rallygap.models.support.bootstrap import resampled_counts

QUANTITIES = {"position": POSITION, "velocity": VELOCITY, "spin": SPIN}
_SCALE = {"position": 1000.0, "velocity": 1.0, "spin": 1.0}  # to mm, m/s, rad/s

# The paper evaluates from 100 to 300 ms in steps of 5 ms.
EVALUATED = FUTURE_TIMES >= 0.0999
HORIZONS_MS = [round(1000 * time) for time in FUTURE_TIMES[EVALUATED]]


@dataclass(frozen=True)
class ErrorStatistics:
    """Statistics of an error at each of H horizons.

    Attributes:
        mean: (H,) NaN where no window has a measurement.
        median: (H,) over the windows.
        std: (H,) over the windows.
        count: (H,) windows with a measurement.
        low: (H,) lower end of the mean's 95 % interval, bootstrapped over recordings.
        high: (H,) its upper end.
    """

    mean: Floats
    median: Floats
    std: Floats
    count: NDArray[np.int64]
    low: Floats
    high: Floats


def deviations(forecast: Forecast, windows: Windows, columns: slice) -> Floats:
    """Return (B, 60, C) forecast less measured states, NaN where nothing was measured."""
    measured = windows.measured[..., columns].all(axis=-1, keepdims=True)
    return np.where(measured, (forecast.states - windows.future)[..., columns], np.nan)


def error_norms(forecast: Forecast, windows: Windows, quantity: str) -> Floats:
    """Return (B, H) error norms at the evaluated horizons; NaN where nothing was measured."""
    away = deviations(forecast, windows, QUANTITIES[quantity])
    return (_SCALE[quantity] * np.linalg.norm(away, axis=-1))[:, EVALUATED]


def error_statistics(
    error: Floats, recordings: np.ndarray, resamples: int, generator: np.random.Generator
) -> ErrorStatistics:
    """Return the statistics of (B, H) errors, NaN left out.

    Args:
        error: (B, H).
        recordings: (B,) the recording of each window; recordings, not windows, are resampled,
            because the windows of one recording are not independent.
        resamples: of the bootstrap; without any, the interval is the mean.
        generator: draws the resamples.
    """
    counted = np.isfinite(error)
    value = np.where(counted, error, 0.0)
    count = counted.sum(axis=0)
    with np.errstate(invalid="ignore", divide="ignore"):
        mean = value.sum(axis=0) / count
        std = np.sqrt(np.where(counted, (value - mean) ** 2, 0.0).sum(axis=0) / count)
        means = _resampled_means(value, counted, recordings, resamples, generator)
    low, high = _quantiles(means, [0.025, 0.975]) if resamples else (mean, mean)
    (median,) = _quantiles(error.astype(np.float64), [0.5])
    return ErrorStatistics(mean, median, std, count, low, high)


def _quantiles(rows: Floats, shares: list[float]) -> Floats:
    """Return (Q, H) quantiles of (R, H) rows, NaN left out."""
    if not len(rows):
        return np.full((len(shares), rows.shape[1]), np.nan)
    if np.isfinite(rows).all():  # numpy takes the columns one by one otherwise
        return np.quantile(rows, shares, axis=0)
    with warnings.catch_warnings():  # a horizon at which nothing was measured has none
        warnings.simplefilter("ignore", RuntimeWarning)
        return np.nanquantile(rows, shares, axis=0)


def _resampled_means(
    value: Floats,
    counted: Bools,
    recordings: np.ndarray,
    resamples: int,
    generator: np.random.Generator,
) -> Floats:
    """Return (R, H) means of (B, H) values where they count, by resampled recordings."""
    if not len(recordings):
        return np.full((resamples, value.shape[1]), np.nan)
    names, member = np.unique(recordings, return_inverse=True)
    sums, counts = (
        np.stack([np.bincount(member, column, len(names)) for column in columns.T], axis=1)
        for columns in (value, counted)
    )
    weights = resampled_counts(len(names), resamples, generator)
    return (weights @ sums) / (weights @ counts)
