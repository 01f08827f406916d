"""Back into the loop: policies trained anew in amended simulators, beside those of before."""

from collections.abc import Hashable, Mapping

import numpy as np
import pandas as pd
from numpy.typing import NDArray

from models.ball.simulator import Simulator
from pipeline.evaluation.predictors import ORACLE
from pipeline.policies.storage import TrainedPolicy
from pipeline.transfer.rates import differences, rates
from pipeline.transfer.transfer_table import PHYSICS, SETTING

Floats = NDArray[np.float64]

ORIGINAL, RETRAINED = "original", "retrained"
BASELINE = {"policy": ORIGINAL, "predictor": PHYSICS}
KEYS = [*SETTING, *BASELINE]  # what tells two experiments apart
CLOSED = ["gap_closed", "closed_low", "closed_high"]


def amended_name(source: str) -> str:
    """What a simulator is called that balls of a source amended."""
    return f"amended_by_{source}"


def anew(trained: TrainedPolicy, source: str, simulator: Simulator) -> TrainedPolicy:
    """Return what a policy is to be trained for that differs in its simulator alone.

    Args:
        trained: the policy of before.
        source: whose balls amended the simulator.
        simulator: amended.
    """
    changes = {"simulator": amended_name(source), "effects": simulator.to_dict()}
    return trained.model_copy(update=changes)


def pooled(played: pd.DataFrame, source: str) -> pd.DataFrame:
    """Return the trials of all sets of a source as those of one set, and each set's after them."""
    if played["set"].nunique() == 1:
        return played
    balls = played["set"] + "/" + played["ball"].astype(str)
    return pd.concat([played.assign(set=source, ball=balls), played], ignore_index=True)


def loop_table(
    played: pd.DataFrame, own: Mapping[Hashable, float], resamples: int, seed: int
) -> pd.DataFrame:
    """Return what each policy and predictor make of the same balls.

    The gap in returns is between the original policy with physics and what it could reach: its
    returns when told by the oracle, or else its rate in its own simulator.

    Args:
        played: one row a policy, predictor and ball, with ``KEYS``, ``repeat``, ``ball``, ``hit``
            and ``returned``.
        own: return rate of the original policies in their own simulator, by their horizons.
        resamples: of the balls, for the 95 % intervals.
        seed: of the resamples.

    Returns:
        One row a setting, policy and predictor: its rates, the difference of its returns to the
        original, and the share of the gap that it closes, which is NaN where no gap is sure.
    """
    table = rates(played, KEYS, resamples, seed)
    gains = differences(played, SETTING, BASELINE, resamples, seed)
    gains = gains[gains["outcome"] == "returns"].drop(columns="outcome")
    closed = pd.DataFrame(
        [
            {**dict(zip(KEYS, key, strict=True)), **dict(zip(CLOSED, shares, strict=True))}
            for setting, part in played.groupby(SETTING, sort=False)
            for key, shares in _shares(part, setting, own, resamples, seed).items()
        ],
        columns=[*KEYS, *CLOSED],
    )
    return table.merge(gains, "left", KEYS).merge(closed, "left", KEYS)


def _shares(
    part: pd.DataFrame,
    setting: tuple[Hashable, ...],
    own: Mapping[Hashable, float],
    resamples: int,
    seed: int,
) -> dict[tuple[Hashable, ...], tuple[float, float, float]]:
    """Return the share of the gap that each policy and predictor close in one setting."""
    returned = {key: _returned(rows) for key, rows in part.groupby(list(BASELINE), sort=False)}
    base = returned.pop(tuple(BASELINE.values()))
    reach = returned.get((ORIGINAL, ORACLE), np.full_like(base, own[setting[1]]))
    return {
        (*setting, *key): share_closed(rate - base, reach - base, resamples, seed)
        for key, rate in returned.items()
    }


def _returned(rows: pd.DataFrame) -> Floats:
    """Return (B,) how often each ball was returned, mean over policies."""
    return rows.groupby("ball")["returned"].mean().to_numpy(dtype=np.float64)


def share_closed(
    gain: Floats, gap: Floats, resamples: int, seed: int
) -> tuple[float, float, float]:
    """Return the share of a gap that closes, with the ends of its 95 % interval.

    Args:
        gain: (B,) of each ball.
        gap: (B,) of each ball.
        resamples: of the balls.
        seed: of the resamples.

    Returns:
        NaN where chance alone may have made the gap: where not 97.5 % of the resamples have one.
    """
    even = np.full(len(gap), 1 / len(gap))
    weights = np.random.default_rng(seed).multinomial(len(gap), even, size=resamples)
    gaps = weights @ gap
    if not resamples or np.quantile(gaps, 0.025) <= 0:
        return np.nan, np.nan, np.nan
    low, high = np.quantile((weights @ gain)[gaps > 0] / gaps[gaps > 0], [0.025, 0.975])
    return float(gain.mean() / gap.mean()), float(low), float(high)
