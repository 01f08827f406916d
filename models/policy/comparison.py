"""Paired comparison of predictors on the same balls, and forecast errors."""

from dataclasses import dataclass

import numpy as np

from models.ball.types import Bools, Floats
from models.policy.forecasts import exact
from models.policy.incoming_balls import IncomingBalls, control_times
from models.policy.settings import HorizonsMs
from models.predictors.errors import error_statistics


@dataclass(frozen=True)
class Interval:
    """A mean and its 95 % interval, bootstrapped over balls."""

    mean: float
    low: float
    high: float


@dataclass(frozen=True)
class Comparison:
    """The same balls with a predictor and with a baseline.

    Attributes:
        difference: of the success rates, predictor minus baseline, paired by ball.
        gained: balls that succeed more often with the predictor, over all policies.
        lost: balls that succeed more often with the baseline.
    """

    difference: Interval
    gained: int
    lost: int


def intervals(trials: Floats, resamples: int, seed: int) -> list[Interval]:
    """Return the means of K quantities over all trials, with their intervals.

    Args:
        trials: (R, B, K) quantities of B balls under each of R policies.
        resamples: of the balls, each with its results under all policies; with 0 the intervals
            are the means.
        seed: of the resamples.
    """
    policies, count, quantities = trials.shape
    balls = np.tile(np.arange(count), policies)
    generator = np.random.default_rng(seed)
    spreads = error_statistics(trials.reshape(-1, quantities), balls, resamples, generator)
    ends = np.stack([spreads.mean, spreads.low, spreads.high], axis=1).tolist()
    return [Interval(*three) for three in ends]


def compare(predictor: Bools, baseline: Bools, resamples: int, seed: int) -> list[Comparison]:
    """Compare two predictors on the same balls, by each of K criteria of success.

    Args:
        predictor: (R, B, K) whether each of B balls succeeds, for example is returned, with the
            predictor under each of R policies.
        baseline: (R, B, K) the same with the baseline.
        resamples: of the balls, as in ``intervals``.
        seed: of the resamples.
    """
    difference = predictor.astype(np.float64) - baseline
    more = difference.sum(axis=0)
    return [
        Comparison(interval, gained=int(gained), lost=int(lost))
        for interval, gained, lost in zip(
            intervals(difference, resamples, seed),
            (more > 0).sum(axis=0),
            (more < 0).sum(axis=0),
            strict=True,
        )
    ]


def forecast_error(incoming: IncomingBalls, horizons: HorizonsMs) -> float:
    """Return the mean distance between forecast and true position, m.

    At the middle horizon, over all control steps before a ball is out of play.
    """
    true = exact(incoming.path, horizons, incoming.start)
    errors = np.linalg.norm((incoming.forecasts - true)[:, :, 1, :3], axis=2)
    in_play = control_times(incoming.start) < incoming.playable[:, 1:]
    return float(errors[in_play].mean())
