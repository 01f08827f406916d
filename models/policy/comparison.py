"""Comparison: the same balls, told of by one predictor and by another."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from models.policy.forecasts import exact
from models.policy.incoming_balls import Incoming, tick_times
from models.policy.settings import HorizonsMs
from models.predictors.errors import error_statistics

Booleans = NDArray[np.bool_]
Floats = NDArray[np.float64]


@dataclass(frozen=True)
class Interval:
    """A mean and the ends of its 95 % interval, bootstrapped over balls."""

    mean: float
    low: float
    high: float


@dataclass(frozen=True)
class Comparison:
    """What becomes of the same balls with one predictor and with another.

    Attributes:
        difference: of the shares of balls that succeed, one minus other, ball by ball: a hard ball
            is hard for both.
        gained: balls that succeed more often with the one, all policies taken together.
        lost: balls that succeed more often with the other.
    """

    difference: Interval
    gained: int
    lost: int


def intervals(trials: Floats, resamples: int, seed: int) -> list[Interval]:
    """Return the means of K quantities over all trials, with their intervals.

    Args:
        trials: (R, B, K) the quantities of each of B balls under each of R policies.
        resamples: of the balls, each with what all policies make of it; without any the intervals
            are their means.
        seed: of the resamples.
    """
    policies, count, quantities = trials.shape
    balls = np.tile(np.arange(count), policies)
    generator = np.random.default_rng(seed)
    found = error_statistics(trials.reshape(-1, quantities), balls, resamples, generator)
    ends = np.stack([found.mean, found.low, found.high], axis=1).tolist()
    return [Interval(*three) for three in ends]


def compare(one: Booleans, other: Booleans, resamples: int, seed: int) -> list[Comparison]:
    """Compare two predictors on the same balls, by each of K ways to succeed.

    Args:
        one: (R, B, K) whether each of B balls succeeds, for example is returned, with the one
            predictor under each of R policies.
        other: (R, B, K) the same with the other.
        resamples: of the balls, as in ``intervals``.
        seed: of the resamples.
    """
    apart = one.astype(np.float64) - other
    more = apart.sum(axis=0)
    return [
        Comparison(difference, gained=int(gained), lost=int(lost))
        for difference, gained, lost in zip(
            intervals(apart, resamples, seed),
            (more > 0).sum(axis=0),
            (more < 0).sum(axis=0),
            strict=True,
        )
    ]


def forecast_error(incoming: Incoming, horizons: HorizonsMs) -> float:
    """Return how far the ball is from where it was forecast, m.

    That is the mean distance at the middle horizon, over all control ticks before a ball is gone.
    """
    true = exact(incoming.path, horizons, incoming.start)
    apart = np.linalg.norm((incoming.forecasts - true)[:, :, 1, :3], axis=2)
    before = tick_times(incoming.start) < incoming.playable[:, 1:]
    return float(apart[before].mean())
