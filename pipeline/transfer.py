"""Tables of sim-to-real: hits and returns with each predictor, and what one gains over another."""

from collections.abc import Sequence
from typing import Any, NamedTuple

import numpy as np
import pandas as pd
from numpy.typing import NDArray

from models.policy.comparison import compare
from pipeline import paper
from pipeline.replay_trials import EveryTick

SETTING = ["set", "horizons_ms"]  # what tells two comparisons apart
FORECASTER = ["predictor", "protocol"]
PHYSICS = "physics"
THE_PAPER = "the paper's"


class Outcome(NamedTuple):
    """Something that a ball can come to: the column of trials, and what reports call it."""

    column: str
    rate: str
    number: str


OUTCOMES = (Outcome("hit", "hit_rate", "hits"), Outcome("returned", "return_rate", "returns"))
NUMBERS = [outcome.number for outcome in OUTCOMES]


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
        row = {**dict(zip(keys, values, strict=True)), "balls": part["ball"].nunique()}
        for outcome in OUTCOMES:
            trials = _trials(part, outcome)
            interval = compare(trials, trials, resamples, seed).one
            row[outcome.number] = trials.sum() / len(trials)
            row[outcome.rate] = interval.mean
            row[f"{outcome.rate}_low"], row[f"{outcome.rate}_high"] = interval.low, interval.high
        rows.append(row)
    return pd.DataFrame(rows)


def differences(played: pd.DataFrame, resamples: int, seed: int) -> pd.DataFrame:
    """Return what every forecaster gains over physics that is asked at every tick.

    Args:
        played: as ``ReplayTrial.results`` returns it.
        resamples: of the shots, for the 95 % intervals.
        seed: of the resamples.

    Returns:
        One row a set, horizons, forecaster and outcome: ``difference`` of the rates on the same
        shots with ``ci_low`` and ``ci_high``; ``gained`` and ``lost``, the shots that came to it
        more often with the forecaster, or with physics.
    """
    rows = []
    for setting, part in played.groupby(SETTING, sort=False):
        by_forecaster = dict(list(part.groupby(FORECASTER, sort=False)))
        physics = by_forecaster.pop((PHYSICS, EveryTick.protocol))
        for forecaster, other in by_forecaster.items():
            for outcome in OUTCOMES:
                trials = _trials(other, outcome), _trials(physics, outcome)
                compared = compare(*trials, resamples, seed)
                key = zip([*SETTING, *FORECASTER], [*setting, *forecaster], strict=True)
                rows.append(
                    {
                        **dict(key),
                        "outcome": outcome.number,
                        "difference": compared.difference.mean,
                        "ci_low": compared.difference.low,
                        "ci_high": compared.difference.high,
                        "gained": compared.gained,
                        "lost": compared.lost,
                    }
                )
    return pd.DataFrame(rows)


def in_the_form_of_the_paper(table: pd.DataFrame, learned: Sequence[str]) -> pd.DataFrame:
    """Return hits and returns, physics beside what was learned, and the paper's below ours.

    Args:
        table: ``rates`` by set, horizons, predictor and protocol.
        learned: the predictors to set beside physics.

    Returns:
        One row a set and learned predictor, and one of the paper's for each set that it has.
    """
    asked = table[table["protocol"] == EveryTick.protocol]
    horizons = list(table["horizons_ms"].unique())
    rows = []
    for name, members in asked.groupby("set", sort=False):
        rows += [_own_row(members, str(name), one) for one in learned]
        if name in paper.SHOTS:
            rows.append(_paper_row(str(name), horizons))
    return pd.DataFrame(rows)


def _own_row(members: pd.DataFrame, name: str, learned: str) -> dict[str, Any]:
    row = {"set": name, "learned_predictor": learned, "shots": members["balls"].iloc[0]}
    for ahead, own in members.groupby("horizons_ms", sort=False):
        for kind, predictor in (("physics", PHYSICS), ("learned", learned)):
            found = own[own["predictor"] == predictor].iloc[0]
            row |= {f"{ahead} ms: {kind} {number}": found[number] for number in NUMBERS}
    return row


def _paper_row(name: str, horizons: Sequence[str]) -> dict[str, Any]:
    row = {"set": name, "learned_predictor": THE_PAPER, "shots": paper.SHOTS[name]}
    for ahead in horizons:
        if (name, ahead) in paper.TRANSFER:
            found = paper.TRANSFER[name, ahead]._asdict().items()
            row |= {f"{ahead} ms: {key.replace('_', ' ')}": value for key, value in found}
    return row


def _trials(part: pd.DataFrame, outcome: Outcome) -> NDArray[np.bool_]:
    """Return (R, B) whether each of B balls came to it under each of R policies."""
    table = part.pivot(index="repeat", columns="ball", values=outcome.column)
    return table.to_numpy(dtype=np.bool_)
