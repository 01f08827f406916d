"""Tables of the returns of sim2real: medians, and how the swap and other receivers change them."""

from collections.abc import Hashable, Mapping, Sequence
from dataclasses import asdict
from itertools import combinations
from typing import NamedTuple

import numpy as np
import pandas as pd

from rallygap.models.arena.truth import draw_truth
from rallygap.models.ball.types import Floats
from rallygap.models.shot_quality.bootstrap import Estimate, resampled_median
from rallygap.models.shot_quality.forest import Forest
from rallygap.models.shot_quality.receivers import RECEIVERS, play_against
from rallygap.models.shot_quality.shots import FEATURES, clearance, shot_features
from rallygap.pipeline.io.schemas import SPIN_COLUMNS
from rallygap.pipeline.params import ShotQualitySettings
from rallygap.pipeline.transfer.returns import LANDED

KEYS = ["set", "horizons_ms", "predictor", "protocol"]  # of an experiment
BASELINE = ("physics", "every_tick")  # predictor and protocol that the others are compared with
METRICS = {  # column: label in figures
    "speed": "ball speed (m/s)",
    "spin": "spin rate (rad/s)",
    "clearance": "clearance over the net (m)",
    "win_probability": "winning probability",
}
OUT_OF_RANGE = {f"out_of_range_{name}": name for name in FEATURES}  # column: feature
OTHER_ARENA = 1  # added to the seed: the truth of the run's own arena stays sealed
NOMINAL = RECEIVERS[0].name


def returns_table(played: pd.DataFrame, forest: Forest) -> pd.DataFrame:
    """Return one row a return: ``KEYS``, ``repeat``, ``ball``, ``METRICS`` and ``OUT_OF_RANGE``.

    Args:
        played: trials of sim2real.
        forest: estimates the winning probability.
    """
    returns = played[played["returned"]].reset_index(drop=True)
    features = return_features(returns)
    spins = returns[[f"after_{name}" for name in SPIN_COLUMNS]].to_numpy()
    table = returns[[*KEYS, "repeat", "ball", "speed"]].assign(
        spin=np.linalg.norm(spins, axis=1),
        clearance=clearance(returns["net_height"].to_numpy()),
        win_probability=forest.probabilities(features),
    )
    out_of_range = pd.DataFrame(forest.out_of_range(features), columns=list(OUT_OF_RANGE))
    return pd.concat([table, out_of_range], axis=1)


def return_features(returns: pd.DataFrame) -> Floats:
    """Return the (R, 9) features of returns."""
    heights = returns["net_height"].to_numpy()
    return shot_features(returns[LANDED].to_numpy(), clearance(heights))


class Experiment(NamedTuple):
    """The returns of one set of balls with one predictor, by all policies.

    Attributes:
        key: values of ``KEYS``.
        returns: mean number over policies.
        medians: of ``METRICS``, by column.
        out_of_range: share of the returns with a feature outside the range of the training shots.
    """

    key: tuple[Hashable, ...]
    returns: float
    medians: dict[str, Estimate]
    out_of_range: float


def experiments(
    played: pd.DataFrame, returns: pd.DataFrame, resamples: int, seed: int
) -> list[Experiment]:
    """Return every experiment.

    Args:
        played: all trials, those without a return included.
        returns: from ``returns_table``.
        resamples: of the balls, for the 95 % intervals.
        seed: of the resamples.
    """
    by_key = dict(list(returns.groupby(KEYS, sort=False)))
    results = []
    for key, trials in played.groupby(KEYS, sort=False):
        members = by_key.get(key, returns.iloc[:0])
        balls = trials["ball"].nunique()
        medians = {
            metric: resampled_median(members[metric], members["ball"], balls, resamples, seed)
            for metric in METRICS
        }
        outside = members[list(OUT_OF_RANGE)].any(axis=1).mean() if len(members) else np.nan
        mean_count = len(members) / trials["repeat"].nunique()
        results.append(Experiment(key, mean_count, medians, outside))
    return results


def quality_table(results: Sequence[Experiment]) -> pd.DataFrame:
    """Return one row an experiment: its values, each median with the ends of its interval."""
    return pd.DataFrame(
        {
            **dict(zip(KEYS, result.key, strict=True)),
            "returns": result.returns,
            **_intervals(result.medians),
            "out_of_range": result.out_of_range,
        }
        for result in results
    )


def swap_table(results: Sequence[Experiment]) -> pd.DataFrame:
    """Return the ratios of all medians to those of ``BASELINE`` on the same balls.

    Returns:
        One row an experiment other than ``BASELINE``: ``KEYS``, and every metric's ratio with the
        ends of its interval.
    """
    physics = {result.key[:2]: result.medians for result in results if result.key[2:] == BASELINE}
    rows = []
    for result in results:
        if result.key[2:] != BASELINE:
            baseline = physics[result.key[:2]]
            ratios = {name: median.ratio(baseline[name]) for name, median in result.medians.items()}
            rows.append({**dict(zip(KEYS, result.key, strict=True)), **_intervals(ratios)})
    return pd.DataFrame(rows)


def out_of_range_table(returns: pd.DataFrame) -> pd.DataFrame:
    """Return the share of the returns outside the range of the training shots, by feature."""
    shares = returns.groupby(KEYS, sort=False)[list(OUT_OF_RANGE)].mean()
    return shares.rename(columns=OUT_OF_RANGE).reset_index()


def _intervals(estimates: Mapping[str, Estimate]) -> dict[str, float]:
    return {
        f"{name}{suffix}": end
        for name, estimate in estimates.items()
        for suffix, end in zip(("", "_low", "_high"), estimate.interval(), strict=True)
    }


def receiver_forests(
    settings: ShotQualitySettings, seed: int
) -> tuple[pd.DataFrame, dict[str, Forest]]:
    """Simulate points against every receiver and train a forest on each.

    Returns:
        One row a receiver, ``win_rate`` the share of the shots that won; and receiver to forest.
    """
    truth = draw_truth(seed + OTHER_ARENA)
    rows, forests = [], {}
    for receiver in RECEIVERS:
        random = np.random.default_rng([seed, *b"receivers", receiver.draw])
        shots = play_against(receiver, truth, settings.points, random)
        forests[receiver.name] = Forest(shots.features, shots.wins, settings.forest, seed)
        rows.append({**asdict(receiver), "shots": len(shots), "win_rate": shots.wins.mean()})
    return pd.DataFrame(rows).rename(columns={"name": "receiver"}), forests


def median_win_probabilities(
    returns: pd.DataFrame, features: Floats, forests: Mapping[str, Forest]
) -> pd.DataFrame:
    """Return the median winning probability of every experiment, one column a forest."""
    probabilities = {name: forest.probabilities(features) for name, forest in forests.items()}
    return returns[KEYS].assign(**probabilities).groupby(KEYS, sort=False)[list(forests)].median()


def order_agreement(medians: pd.DataFrame, forest: str, reference: str = NOMINAL) -> float:
    """Return the share of pairs of experiments that two forests put in the same order.

    Pairs are on the same set and horizons. A tie agrees with a tie alone. NaN without any pair.
    """
    agreements = []
    for _, group in medians.groupby(KEYS[:2], sort=False):
        for experiment, other in combinations(group.index, 2):
            difference = group.loc[experiment] - group.loc[other]
            agreements.append(np.sign(difference[forest]) == np.sign(difference[reference]))
    return float(np.mean(agreements)) if agreements else np.nan
