"""Policies retrained in amended simulators, compared with the original ones."""

from collections.abc import Hashable, Mapping

import numpy as np
import pandas as pd

from rallygap.models.ball.simulator import Simulator
from rallygap.models.ball.types import Floats
from rallygap.models.support.clustered_means import clustered_mean
from rallygap.pipeline.evaluation.predictors import ORACLE
from rallygap.pipeline.policies.storage import TrainedPolicy
from rallygap.pipeline.transfer.rates import OUTCOMES, differences, rates, trials_of
from rallygap.pipeline.transfer.returns import PHYSICS, SETTING

ORIGINAL, RETRAINED = "original", "retrained"
BASELINE = {"policy": ORIGINAL, "predictor": PHYSICS}
KEYS = [*SETTING, *BASELINE]  # of an experiment
RETURNED = [outcome.column for outcome in OUTCOMES].index("returned")
CLOSED = ["gap_closed", "closed_low", "closed_high"]


def amended_name(source: str) -> str:
    """Return the name of the simulator amended from a source."""
    return f"amended_by_{source}"


def in_simulator(trained: TrainedPolicy, source: str, simulator: Simulator) -> TrainedPolicy:
    """Return the description of the same policy trained in an amended simulator.

    Args:
        trained: the original policy.
        source: from whose shots the simulator was amended.
        simulator: amended.
    """
    changes = {"simulator": amended_name(source), "effects": simulator.to_dict()}
    return trained.model_copy(update=changes)


def pooled(played: pd.DataFrame, source: str) -> pd.DataFrame:
    """Return the trials of all sets of a source as one set, followed by each set's."""
    if set(played["set"]) == {source}:
        return played
    balls = played["set"] + "/" + played["ball"].astype(str)
    return pd.concat([played.assign(set=source, ball=balls), played], ignore_index=True)


def retraining_table(played: pd.DataFrame, own: Mapping[Hashable, float]) -> pd.DataFrame:
    """Return rates, differences and shares of the gap closed, by policy and predictor.

    The gap in return rates is between the original policy with physics and the same policy with the
    oracle, or without an oracle its rate in its own simulator.

    Args:
        played: as ``rates`` takes them, with ``KEYS``.
        own: return rates of the original policies in their own simulator, by horizons.

    Returns:
        One row per setting, policy and predictor: its rates, the difference of its return rate to
        the baseline's, and the share of the gap that it closes; NaN without a significant gap.
    """
    table = rates(played, KEYS)
    gains = differences(played, SETTING, BASELINE)
    gains = gains[gains["outcome"] == "returns"].drop(columns="outcome")
    closed = pd.DataFrame(
        [
            {**dict(zip(KEYS, key, strict=True)), **dict(zip(CLOSED, shares, strict=True))}
            for setting, part in played.groupby(SETTING, sort=False)
            for key, shares in _shares(part, setting, own).items()
        ],
        columns=[*KEYS, *CLOSED],
    )
    return table.merge(gains, "left", KEYS).merge(closed, "left", KEYS)


def _shares(
    part: pd.DataFrame, setting: tuple[Hashable, ...], own: Mapping[Hashable, float]
) -> dict[tuple[Hashable, ...], tuple[float, float, float]]:
    """Return the shares of the gap that policies and predictors close in one setting."""
    groups = {key: trials_of(rows) for key, rows in part.groupby(list(BASELINE), sort=False)}
    returned = {key: trials[..., RETURNED] for key, (trials, _) in groups.items()}
    recordings = groups[tuple(BASELINE.values())][1]
    base = returned.pop(tuple(BASELINE.values()))
    best = returned.get((ORIGINAL, ORACLE), np.full_like(base, own[setting[1]]))
    return {
        (*setting, *key): share_closed(rate - base, best - base, recordings)
        for key, rate in returned.items()
    }


def share_closed(gain: Floats, gap: Floats, recordings: np.ndarray) -> tuple[float, float, float]:
    """Return the share of a gap that closes, with its 95 % interval.

    Args:
        gain: (R, B) of each ball in each training.
        gap: (R, B), likewise.
        recordings: (B,) that balls are from.

    Returns:
        NaN where the gap is not significant: where its interval contains zero.
    """
    if clustered_mean(gap[..., None], recordings).low[0] <= 0:
        return np.nan, np.nan, np.nan
    share = float(gain.mean() / gap.mean())
    deviations = (gain - share * gap) / gap.mean()  # delta method
    margin = float(clustered_mean(deviations[..., None], recordings).high[0])
    return share, share - margin, share + margin
