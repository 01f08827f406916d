"""The quality of returns as tables: medians, receivers, and how far the forest can be trusted."""

from collections.abc import Hashable, Mapping, Sequence
from itertools import combinations
from typing import NamedTuple

import numpy as np
import pandas as pd
from numpy.typing import NDArray

from models.shot_quality.forest import Forest
from models.shot_quality.forest_evaluation import (
    Fold,
    Method,
    brier,
    calibration,
    folds,
    held_out,
    importance,
    roc_auc,
    score,
)
from models.shot_quality.medians import Resampled, resampled_median
from models.shot_quality.shots import FEATURES, Shots, clearance, described
from pipeline.io.schemas import SPIN_COLUMNS
from pipeline.transfer.returns import LANDED

Floats = NDArray[np.float64]

KEYS = ["set", "horizons_ms", "predictor", "protocol"]  # what tells two experiments apart
SETTING = ["set", "horizons_ms"]  # within which predictors are put in order
BASELINE = ("physics", "every_tick")  # predictor and protocol that the others are set against
BINS = 8  # of the calibration


class Metric(NamedTuple):
    """Something that tells of a return's quality: its column, and what figures call it."""

    column: str
    title: str


METRICS = (
    Metric("speed", "ball speed (m/s)"),
    Metric("spin", "spin rate (rad/s)"),
    Metric("clearance", "clearance over the net (m)"),
    Metric("win_probability", "winning probability"),
)


def returns_table(played: pd.DataFrame, forest: Forest) -> pd.DataFrame:
    """Return one row a return: ``KEYS``, ``repeat``, ``ball``, the metrics, ``unlike_<feature>``.

    Args:
        played: trials of sim2real.
        forest: tells the winning probability.
    """
    returns = played[played["returned"]].reset_index(drop=True)
    features = return_features(returns)
    spins = returns[[f"after_{name}" for name in SPIN_COLUMNS]].to_numpy()
    table = returns[[*KEYS, "repeat", "ball", "speed"]].assign(
        spin=np.linalg.norm(spins, axis=1),
        clearance=clearance(returns["net_height"].to_numpy()),
        win_probability=forest.probabilities(features),
    )
    unlike = forest.unlike(features)
    names = [f"unlike_{name}" for name in FEATURES]
    return pd.concat([table, pd.DataFrame(unlike, columns=names)], axis=1)


def return_features(returns: pd.DataFrame) -> Floats:
    """Return the (R, 9) features of returns."""
    heights = returns["net_height"].to_numpy()
    return described(returns[LANDED].to_numpy(), clearance(heights))


class Experiment(NamedTuple):
    """What came back of the balls that one predictor told one set of policies.

    Attributes:
        key: values of ``KEYS``.
        returns: mean number over policies.
        medians: of the metrics, by column.
        unlike: share of the returns of which any feature is beyond what the forest was trained on.
    """

    key: tuple[Hashable, ...]
    returns: float
    medians: dict[str, Resampled]
    unlike: float


def experiments(
    played: pd.DataFrame, returns: pd.DataFrame, resamples: int, seed: int
) -> list[Experiment]:
    """Return every experiment.

    Args:
        played: all trials, those too in which no ball came back.
        returns: as ``returns_table`` gives them.
        resamples: of the balls, for the 95 % intervals.
        seed: of the resamples.
    """
    beyond = [f"unlike_{name}" for name in FEATURES]
    by_key = dict(list(returns.groupby(KEYS, sort=False)))
    found = []
    for key, trials in played.groupby(KEYS, sort=False):
        own = by_key.get(key, returns.iloc[:0])
        balls = trials["ball"].nunique()
        medians = {
            column: resampled_median(own[column], own["ball"], balls, resamples, seed)
            for column, _ in METRICS
        }
        unlike = own[beyond].any(axis=1).mean() if len(own) else np.nan
        found.append(Experiment(key, len(own) / trials["repeat"].nunique(), medians, unlike))
    return found


def quality_table(found: Sequence[Experiment]) -> pd.DataFrame:
    """Return one row an experiment: its values, each median with the ends of its interval."""
    return pd.DataFrame(
        [
            _named(one) | {"returns": one.returns} | _ends(one.medians) | {"unlike": one.unlike}
            for one in found
        ]
    )


def swap_table(found: Sequence[Experiment]) -> pd.DataFrame:
    """Return how many times the medians of physics those of the other predictors are.

    Returns:
        One row an experiment other than ``BASELINE``: ``KEYS``, and every metric with the ends of
        its interval. A resample has the same balls for both.
    """
    baselines = {one.key[:2]: one.medians for one in found if one.key[2:] == BASELINE}
    rows = []
    for one in found:
        if one.key[2:] != BASELINE:
            physics = baselines[one.key[:2]]
            times = {name: median.over(physics[name]) for name, median in one.medians.items()}
            rows.append(_named(one) | _ends(times))
    return pd.DataFrame(rows)


def _named(one: Experiment) -> dict[str, Hashable]:
    return dict(zip(KEYS, one.key, strict=True))


def _ends(numbers: Mapping[str, Resampled]) -> dict[str, float]:
    return {
        column: end
        for name, number in numbers.items()
        for column, end in zip(
            (name, f"{name}_low", f"{name}_high"), number.interval(), strict=True
        )
    }


def unlike_table(returns: pd.DataFrame) -> pd.DataFrame:
    """Return which share of the returns is beyond the training shots, by feature."""
    columns = {f"unlike_{name}": name for name in FEATURES}
    shares = returns.groupby(KEYS, sort=False)[list(columns)].mean()
    return shares.rename(columns=columns).reset_index()


def win_medians(
    returns: pd.DataFrame, features: Floats, forests: Mapping[str, Forest]
) -> pd.DataFrame:
    """Return the median winning probability of every experiment, a column a forest."""
    told = {name: forest.probabilities(features) for name, forest in forests.items()}
    return returns[KEYS].assign(**told).groupby(KEYS, sort=False)[list(forests)].median()


def order_kept(medians: pd.DataFrame, forest: str, reference: str) -> float:
    """Return the share of pairs of experiments in a setting that both forests order alike.

    Ties count as an order of their own; NaN where no setting has two experiments.
    """
    alike = []
    for _, part in medians.groupby(SETTING, sort=False):
        for one, other in combinations(part.index, 2):
            apart = part.loc[one] - part.loc[other]
            alike.append(np.sign(apart[forest]) == np.sign(apart[reference]))
    return float(np.mean(alike)) if alike else np.nan


class Judged(NamedTuple):
    """A method's probabilities of shots from matches that it had not seen."""

    name: str
    parts: list[Fold]
    told: Floats


def judged(
    shots: Shots, wins: NDArray[np.bool_], methods: Mapping[str, Method], count: int
) -> list[Judged]:
    """Return what every method makes of shots from matches left out; see ``folds``."""
    found = []
    for name, method in methods.items():
        parts = folds(shots.features, wins, shots.matches, count, method)
        found.append(Judged(name, parts, held_out(parts, shots.features)))
    return found


def score_rows(
    shots: Shots, wins: NDArray[np.bool_], methods: Sequence[Judged], resamples: int, seed: int
) -> list[dict[str, Hashable]]:
    """Return a row a method: ROC-AUC and Brier score with their intervals."""
    rows = []
    for name, _, told in methods:
        row: dict[str, Hashable] = {"method": name, "shots": len(shots), "share": wins.mean()}
        for title, measure in (("roc_auc", roc_auc), ("brier", brier)):
            ends = score(measure, wins, told, shots.matches, resamples, seed)
            row |= zip((title, f"{title}_low", f"{title}_high"), ends, strict=True)
        rows.append(row)
    return rows


def calibration_table(shots: Shots, methods: Sequence[Judged]) -> pd.DataFrame:
    """Return what share of the shots won, by the probability that each method gave them."""
    rows = [
        {"method": name, "shots": count, "probability": told_mean, "share": share}
        for name, _, told in methods
        for count, told_mean, share in calibration(shots.wins, told, BINS)
    ]
    return pd.DataFrame(rows)


def importance_table(shots: Shots, parts: list[Fold], seed: int) -> pd.DataFrame:
    """Return by how much the ROC-AUC falls without each feature, and what goes along with it."""
    falls = importance(parts, shots.features, shots.wins, np.random.default_rng(seed))
    together = pd.DataFrame(shots.features).corr("spearman").fillna(0.0).to_numpy(copy=True)
    np.fill_diagonal(together, 0.0)
    partner = np.abs(together).argmax(axis=1)
    table = pd.DataFrame(
        {
            "feature": FEATURES,
            "fall_of_roc_auc": falls.mean(axis=0),
            "std": falls.std(axis=0),
            "goes_with": [FEATURES[one] for one in partner],
            "correlation": together[np.arange(len(partner)), partner],
        }
    )
    return table.sort_values("fall_of_roc_auc", ascending=False, kind="stable")
