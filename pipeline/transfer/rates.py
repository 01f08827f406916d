"""Outcomes of trials: how often balls are hit and returned, and what one forecaster gains."""

from collections.abc import Mapping, Sequence
from typing import NamedTuple

import numpy as np
import pandas as pd
from numpy.typing import NDArray

from models.policy.comparison import compare, intervals


class Outcome(NamedTuple):
    """Something that a ball can come to: the column of trials, and what reports call it."""

    column: str
    rate: str
    number: str


OUTCOMES = (Outcome("hit", "hit_rate", "hits"), Outcome("returned", "return_rate", "returns"))


def rates(played: pd.DataFrame, keys: Sequence[str], resamples: int, seed: int) -> pd.DataFrame:
    """Return how often balls were hit and returned.

    Args:
        played: one row a policy and ball: ``repeat``, ``ball``, ``hit``, ``returned`` and ``keys``.
        keys: columns that tell experiments apart.
        resamples: of the balls, for the 95 % intervals.
        seed: of the resamples.

    Returns:
        One row an experiment: ``keys``; ``balls``; ``hits`` and ``returns``, their mean numbers
        over the policies; ``hit_rate`` and ``return_rate`` with the ends of their intervals,
        ``..._low`` and ``..._high``.
    """
    rows = []
    for values, part in played.groupby(list(keys), sort=False, dropna=False):
        trials = _trials(part)
        row = {**dict(zip(keys, values, strict=True)), "balls": trials.shape[1]}
        numbers = trials.sum(axis=(0, 1)) / len(trials)
        shares = intervals(trials.astype(np.float64), resamples, seed)
        for outcome, number, share in zip(OUTCOMES, numbers, shares, strict=True):
            row[outcome.number], row[outcome.rate] = number, share.mean
            row[f"{outcome.rate}_low"], row[f"{outcome.rate}_high"] = share.low, share.high
        rows.append(row)
    return pd.DataFrame(rows)


def differences(
    played: pd.DataFrame,
    setting: Sequence[str],
    baseline: Mapping[str, str],
    resamples: int,
    seed: int,
) -> pd.DataFrame:
    """Return what every forecaster gains over one of them, on the same balls.

    Args:
        played: one row a policy and ball: ``repeat``, ``ball``, ``hit``, ``returned``, ``setting``
            and the columns of the baseline.
        setting: columns that tell comparisons apart.
        baseline: the forecaster that the others are compared with: columns that tell forecasters
            apart, and what they are for this one.
        resamples: of the balls, for the 95 % intervals.
        seed: of the resamples.

    Returns:
        One row a setting, forecaster and outcome: ``difference`` of the rates with ``ci_low`` and
        ``ci_high``; ``gained`` and ``lost``, the balls that came to it more often with the
        forecaster, or with the baseline.
    """
    keys = [*setting, *baseline]
    rows = []
    for values, part in played.groupby(list(setting), sort=False):
        by_forecaster = {key: _trials(own) for key, own in part.groupby(list(baseline), sort=False)}
        base = by_forecaster.pop(tuple(baseline.values()))
        for forecaster, trials in by_forecaster.items():
            compared = compare(trials, base, resamples, seed)
            for outcome, found in zip(OUTCOMES, compared, strict=True):
                rows.append(
                    {
                        **dict(zip(keys, [*values, *forecaster], strict=True)),
                        "outcome": outcome.number,
                        "difference": found.difference.mean,
                        "ci_low": found.difference.low,
                        "ci_high": found.difference.high,
                        "gained": found.gained,
                        "lost": found.lost,
                    }
                )
    return pd.DataFrame(rows)


def _trials(part: pd.DataFrame) -> NDArray[np.bool_]:
    """Return (R, B, K) whether each of B balls came to the outcomes under each of R policies."""
    tables = [
        part.pivot(index="repeat", columns="ball", values=outcome.column) for outcome in OUTCOMES
    ]
    return np.stack([table.to_numpy(dtype=np.bool_) for table in tables], axis=2)
