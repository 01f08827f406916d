"""Rates and paired differences of the study, over trainings and recordings."""

from collections.abc import Iterator, Sequence

import numpy as np
import pandas as pd

from models.ball.types import Floats
from models.predictors.errors import resampled_over_draws

RESAMPLES = 20_000
OUTCOMES = {"hit": "hits", "returned": "returns"}  # columns of trials, and names in reports


def rates(played: pd.DataFrame, keys: Sequence[str], seed: int) -> pd.DataFrame:
    """Return hit and return rates with 95 % intervals.

    Intervals come from a bootstrap that draws recordings, and trainings, with replacement.

    Args:
        played: one row a training (``repeat``) and shot (``set``, ``ball``), with ``recording``,
            ``hit``, ``returned`` and the keys.
        keys: columns that identify an experiment.
        seed: of the bootstrap.
    """
    rows = []
    for values, part in played.groupby(list(keys), sort=False):
        trials, recordings = _trials(part)
        row = {**dict(zip(keys, values, strict=True)), "shots": len(recordings)}
        row["trainings"] = len(trials)
        drawn = resampled_over_draws(trials, recordings, RESAMPLES, np.random.default_rng(seed))
        ends = np.quantile(drawn, [0.025, 0.975], axis=0)
        for k, name in enumerate(OUTCOMES.values()):
            row[name] = trials[..., k].mean()
            row[f"{name}_low"], row[f"{name}_high"] = ends[:, k]
        rows.append(row)
    return pd.DataFrame(rows)


def differences(
    played: pd.DataFrame, setting: Sequence[str], compared: str, baseline: str, seed: int
) -> pd.DataFrame:
    """Return differences of rates to a baseline's, paired by training and shot.

    Args:
        played: as ``rates`` takes them.
        setting: columns that identify a comparison.
        compared: the column of what is compared.
        baseline: its value that the others are compared with.
        seed: of the bootstrap.

    Returns:
        One row a setting, value and outcome: ``difference``, its 95 % interval ``ci_low`` and
        ``ci_high``, its two-sided ``p``, and ``p_holm``, which allows for all comparisons of
        the table with the same outcome.
    """
    rows = [
        {**dict(zip(setting, values, strict=True)), **row}
        for values, part in played.groupby(list(setting), sort=False)
        for row in _differences(part, compared, baseline, seed)
    ]
    table = pd.DataFrame(rows)
    table["p_holm"] = table.groupby("outcome")["p"].transform(holm)
    return table


def _differences(
    part: pd.DataFrame, compared: str, baseline: str, seed: int
) -> Iterator[dict[str, str | float]]:
    by_value = {str(value): _trials(rows) for value, rows in part.groupby(compared, sort=False)}
    base, recordings = by_value.pop(baseline)
    for value, (trials, _) in by_value.items():
        difference = trials - base
        random = np.random.default_rng(seed)
        drawn = resampled_over_draws(difference, recordings, RESAMPLES, random)
        low, high = np.quantile(drawn, [0.025, 0.975], axis=0)
        for k, outcome in enumerate(OUTCOMES.values()):
            yield {
                compared: value,
                "outcome": outcome,
                "difference": difference[..., k].mean(),
                "ci_low": low[k],
                "ci_high": high[k],
                "p": two_sided(drawn[:, k]),
            }


def two_sided(drawn: Floats) -> float:
    """Return how probable a mean at least as far from zero is without a difference."""
    below, above = (drawn <= 0).sum(), (drawn >= 0).sum()
    return float(min(2 * (1 + min(below, above)) / (1 + len(drawn)), 1.0))


def holm(p: pd.Series) -> pd.Series:
    """Return p-values that allow for the number of comparisons (Holm 1979)."""
    order = p.sort_values(kind="stable").index
    left = len(p) - np.arange(len(p))
    adjusted = np.minimum(np.maximum.accumulate(p[order].to_numpy() * left), 1.0)
    return pd.Series(adjusted, index=order).reindex(p.index)


def _trials(part: pd.DataFrame) -> tuple[Floats, np.ndarray]:
    """Return (D, B, 2) outcomes of B shots with D trainings, and the recording of each shot."""
    shot = ["set", "ball"]
    tables = [part.pivot(index="repeat", columns=shot, values=one) for one in OUTCOMES]
    recordings = part.drop_duplicates(shot).set_index(shot)["recording"]
    outcomes = np.stack([table.to_numpy(dtype=np.float64) for table in tables], axis=2)
    return outcomes, recordings.loc[tables[0].columns].to_numpy()
