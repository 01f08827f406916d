"""Comparison: the same balls, told of by one predictor and by another."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from models.policy.forecasts import exact
from models.policy.incoming import Incoming, tick_times
from models.policy.settings import HorizonsMs
from models.predictors.errors import spread

Booleans = NDArray[np.bool_]


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
        one: share of the balls that succeed with the one.
        other: with the other.
        difference: of the shares, one minus other, ball by ball: a hard ball is hard for both.
        gained: balls that succeed more often with the one, all policies taken together.
        lost: balls that succeed more often with the other.
    """

    one: Interval
    other: Interval
    difference: Interval
    gained: int
    lost: int


def compare(one: Booleans, other: Booleans, resamples: int, seed: int) -> Comparison:
    """Compare two predictors on the same balls.

    Args:
        one: (R, B) whether each of B balls succeeds, for example is returned, with the one
            predictor under each of R policies.
        other: (R, B) the same with the other.
        resamples: of the balls, each with what all policies make of it; without any the intervals
            are their means.
        seed: of the resamples.
    """
    first, second = one.astype(np.float64), other.astype(np.float64)
    trials = np.stack([first, second, first - second], axis=2).reshape(-1, 3)
    balls = np.tile(np.arange(one.shape[1]), len(one))
    found = spread(trials, balls, resamples, np.random.default_rng(seed))
    ends = np.stack([found.mean, found.low, found.high], axis=1).tolist()
    more = (first - second).sum(axis=0)
    return Comparison(
        one=Interval(*ends[0]),
        other=Interval(*ends[1]),
        difference=Interval(*ends[2]),
        gained=int((more > 0).sum()),
        lost=int((more < 0).sum()),
    )


def forecast_error(incoming: Incoming, horizons: HorizonsMs) -> float:
    """Return how far the ball is from where it was forecast, m.

    That is the mean distance at the middle horizon, over all control ticks before a ball is gone.
    """
    true = exact(incoming.path, horizons, incoming.start)
    apart = np.linalg.norm((incoming.forecasts - true)[:, :, 1, :3], axis=2)
    before = tick_times(incoming.start) < incoming.playable[:, 1:]
    return float(apart[before].mean())
