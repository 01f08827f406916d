"""Hit and return rates of trials, and their paired differences.

Intervals are over trainings, which differ only in the seed, and recordings, whose shots share
players and cameras. Where trials name no recording, every ball is one.
"""

from collections.abc import Iterator, Mapping, Sequence
from typing import Any, NamedTuple

import numpy as np
import pandas as pd

from rallygap.models.ball.types import Floats
from rallygap.models.support.clustered_means import clustered_mean


class Outcome(NamedTuple):
    """An outcome of a shot: its column in trials, and its columns in reports."""

    column: str
    rate: str
    counts: str


COMPARED = ["difference", "ci_low", "ci_high", "p", "gained", "lost"]  # columns of differences
OUTCOMES = (Outcome("hit", "hit_rate", "hits"), Outcome("returned", "return_rate", "returns"))


def rates(played: pd.DataFrame, keys: Sequence[str]) -> pd.DataFrame:
    """Return the hit and return rates of experiments.

    Args:
        played: one row per training (``repeat``) and shot (``ball``, and ``set`` where there is
            one), with ``hit``, ``returned`` and ``keys``, and possibly ``recording``.
        keys: columns that identify an experiment.

    Returns:
        One row per experiment: ``keys``; ``balls`` and ``trainings``; ``hits`` and ``returns``,
        mean numbers over the trainings; ``hit_rate`` and ``return_rate`` with their 95 % intervals,
        ``..._low`` and ``..._high``.
    """
    rows = []
    for values, part in played.groupby(list(keys), sort=False, dropna=False):
        trials, recordings = trials_of(part)
        row = {**dict(zip(keys, values, strict=True)), "balls": len(recordings)}
        row["trainings"] = len(trials)
        means = clustered_mean(trials, recordings)
        for k, outcome in enumerate(OUTCOMES):
            row[outcome.counts] = trials[..., k].sum() / len(trials)
            row[outcome.rate] = means.mean[k]
            row[f"{outcome.rate}_low"] = max(means.low[k], 0.0)
            row[f"{outcome.rate}_high"] = min(means.high[k], 1.0)
        rows.append(row)
    return pd.DataFrame(rows)


def differences(
    played: pd.DataFrame, setting: Sequence[str], baseline: Mapping[str, str]
) -> pd.DataFrame:
    """Return differences of rates to a baseline's, paired by training and ball.

    Args:
        played: as ``rates`` takes them, with ``setting`` and the columns of the baseline.
        setting: columns that identify a comparison.
        baseline: columns that identify what is compared, and their values for the baseline.

    Returns:
        One row per setting, compared value and outcome: ``difference`` with its 95 % interval,
        ``ci_low`` and ``ci_high``; its two-sided ``p``, and ``p_holm``, which allows for all
        comparisons of the table with the same outcome; ``gained`` and ``lost``, the balls with the
        outcome more often than with the baseline, or less often.
    """
    rows = [
        {**dict(zip(setting, values, strict=True)), **row}
        for values, part in played.groupby(list(setting), sort=False)
        for row in _differences(part, baseline)
    ]
    columns = [*setting, *baseline, "outcome", *COMPARED]
    table = pd.DataFrame(rows, columns=columns)
    table["p_holm"] = table.groupby("outcome")["p"].transform(holm)
    return table


def _differences(part: pd.DataFrame, baseline: Mapping[str, str]) -> Iterator[dict[str, Any]]:
    by_value = {key: trials_of(rows) for key, rows in part.groupby(list(baseline), sort=False)}
    base, recordings = by_value.pop(tuple(baseline.values()))
    for value, (trials, _) in by_value.items():
        difference = trials - base
        means, more = clustered_mean(difference, recordings), difference.sum(axis=0)
        for k, outcome in enumerate(OUTCOMES):
            yield {
                **dict(zip(baseline, value, strict=True)),
                "outcome": outcome.counts,
                "difference": means.mean[k],
                "ci_low": means.low[k],
                "ci_high": means.high[k],
                "p": means.p[k],
                "gained": int((more[:, k] > 0).sum()),
                "lost": int((more[:, k] < 0).sum()),
            }


def trials_of(part: pd.DataFrame) -> tuple[Floats, np.ndarray]:
    """Return what happened to each of B balls, and the (B,) recordings that they are from.

    Args:
        part: as ``rates`` takes them, of one experiment.

    Returns:
        (R, B, K) whether a ball had an outcome in a training, 0 or 1; and the recordings.
    """
    shot = [name for name in ("set", "ball") if name in part]
    tables = [
        part.pivot(index="repeat", columns=shot, values=outcome.column) for outcome in OUTCOMES
    ]
    outcomes = np.stack([table.to_numpy(dtype=np.float64) for table in tables], axis=2)
    if "recording" not in part:
        return outcomes, np.arange(outcomes.shape[1])
    recordings = part.drop_duplicates(shot).set_index(shot)["recording"]
    return outcomes, recordings.loc[tables[0].columns].to_numpy()


def holm(p: pd.Series) -> pd.Series:
    """Return p-values that allow for the number of comparisons (Holm 1979)."""
    order = p.sort_values(kind="stable").index
    left = len(p) - np.arange(len(p))
    adjusted = np.minimum(np.maximum.accumulate(p[order].to_numpy() * left), 1.0)
    return pd.Series(adjusted, index=order).reindex(p.index)
