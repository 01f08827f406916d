"""Hit and return rates of trials, and their paired differences between predictors."""

from collections.abc import Mapping, Sequence
from typing import NamedTuple

import numpy as np
import pandas as pd
from numpy.typing import NDArray

from models.ball.types import Floats
from models.predictors.errors import error_statistics


class Outcome(NamedTuple):
    """An outcome of a shot: its column in trials, and its columns in reports."""

    column: str
    rate: str
    counts: str


OUTCOMES = (Outcome("hit", "hit_rate", "hits"), Outcome("returned", "return_rate", "returns"))


def rates(played: pd.DataFrame, keys: Sequence[str], resamples: int, seed: int) -> pd.DataFrame:
    """Return the hit and return rates of experiments.

    Args:
        played: one row per policy and ball: ``repeat``, ``ball``, ``hit``, ``returned``, ``keys``.
        keys: columns that identify an experiment.
        resamples: of the balls, for the 95 % intervals.
        seed: of the resamples.

    Returns:
        One row per experiment: ``keys``; ``balls``; ``hits`` and ``returns``, mean numbers over
        the policies; ``hit_rate`` and ``return_rate`` with their intervals, ``..._low`` and
        ``..._high``.
    """
    rows = []
    for values, part in played.groupby(list(keys), sort=False, dropna=False):
        trials = _trials(part)
        row = {**dict(zip(keys, values, strict=True)), "balls": trials.shape[1]}
        counts = trials.sum(axis=(0, 1)) / len(trials)
        shares = intervals(trials.astype(np.float64), resamples, seed)
        for outcome, count, share in zip(OUTCOMES, counts, shares, strict=True):
            row[outcome.counts] = count
            row |= zip(
                (f"{outcome.rate}{end}" for end in ("", "_low", "_high")), share, strict=True
            )
        rows.append(row)
    return pd.DataFrame(rows)


def differences(
    played: pd.DataFrame,
    setting: Sequence[str],
    baseline: Mapping[str, str],
    resamples: int,
    seed: int,
) -> pd.DataFrame:
    """Return the differences of predictors' rates to a baseline's, paired by ball.

    Args:
        played: one row per policy and ball: ``repeat``, ``ball``, ``hit``, ``returned``,
            ``setting`` and the columns of the baseline.
        setting: columns that identify a comparison.
        baseline: columns that identify a predictor, and their values for the baseline.
        resamples: of the balls, for the 95 % intervals.
        seed: of the resamples.

    Returns:
        One row per setting, predictor and outcome: ``difference`` of the rates with ``ci_low`` and
        ``ci_high``; ``gained`` and ``lost``, the balls with the outcome more often with the
        predictor, or with the baseline.
    """
    keys = [*setting, *baseline]
    rows = []
    for values, part in played.groupby(list(setting), sort=False):
        by_predictor = {
            key: _trials(rows_of) for key, rows_of in part.groupby(list(baseline), sort=False)
        }
        base = by_predictor.pop(tuple(baseline.values()))
        for predictor, trials in by_predictor.items():
            difference = trials.astype(np.float64) - base
            ends, more = intervals(difference, resamples, seed), difference.sum(axis=0)
            for number, outcome in enumerate(OUTCOMES):
                rows.append(
                    {
                        **dict(zip(keys, [*values, *predictor], strict=True)),
                        "outcome": outcome.counts,
                        **dict(zip(("difference", "ci_low", "ci_high"), ends[number], strict=True)),
                        "gained": int((more[:, number] > 0).sum()),
                        "lost": int((more[:, number] < 0).sum()),
                    }
                )
    return pd.DataFrame(rows)


def intervals(trials: Floats, resamples: int, seed: int) -> list[list[float]]:
    """Return mean and ends of the 95 % interval of K quantities over all trials.

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
    ends: list[list[float]] = np.stack([spreads.mean, spreads.low, spreads.high], axis=1).tolist()
    return ends


def _trials(part: pd.DataFrame) -> NDArray[np.bool_]:
    """Return (R, B, K) whether each of B balls had each outcome under each of R policies."""
    tables = [
        part.pivot(index="repeat", columns="ball", values=outcome.column) for outcome in OUTCOMES
    ]
    return np.stack([table.to_numpy(dtype=np.bool_) for table in tables], axis=2)
