"""Tables of the cross-validation: scores, calibration and permutation importance."""

from collections.abc import Hashable, Mapping
from typing import NamedTuple

import numpy as np
import pandas as pd

from rallygap.models.ball.types import Bools, Floats
from rallygap.models.shot_quality.forest import (
    Fold,
    bootstrap_score,
    brier,
    calibration,
    classifiers,
    cross_validate,
    held_out_probabilities,
    permutation_importance,
    roc_auc,
)
from rallygap.models.shot_quality.shots import FEATURES, Shots
from rallygap.pipeline.params import ShotQualitySettings

BINS = 8  # of the calibration


class Validation(NamedTuple):
    """The cross-validation of a classifier for a (B,) outcome: (B,) held-out probabilities."""

    outcome: Bools
    folds: list[Fold]
    probabilities: Floats


Validations = Mapping[tuple[str, str], Validation]  # by outcome and classifier


def validate(shots: Shots, settings: ShotQualitySettings, seed: int) -> Validations:
    """Cross-validate every classifier for both outcomes, ``wins`` and ``point``.

    Raises:
        ValueError: see ``cross_validate``.
    """
    results = {}
    for outcome, values in {"wins": shots.wins, "point": shots.point}.items():
        for name, classifier in classifiers(settings.forest, seed).items():
            folds = cross_validate(
                classifier, shots.features, values, shots.matches, settings.folds
            )
            probabilities = held_out_probabilities(folds, shots.features)
            results[outcome, name] = Validation(values, folds, probabilities)
    return results


def score_table(shots: Shots, validations: Validations, resamples: int, seed: int) -> pd.DataFrame:
    """Return ROC-AUC and Brier score with their intervals, one row an outcome and classifier."""
    rows = []
    for (outcome, name), result in validations.items():
        row: dict[str, Hashable] = {"outcome": outcome, "method": name, "shots": len(shots)}
        row["share"] = result.outcome.mean()
        for title, metric in (("roc_auc", roc_auc), ("brier", brier)):
            estimate = bootstrap_score(
                metric, result.outcome, result.probabilities, shots.matches, resamples, seed
            )
            names = (title, f"{title}_low", f"{title}_high")
            row |= zip(names, estimate.interval(), strict=True)
        rows.append(row)
    return pd.DataFrame(rows)


def calibration_table(validations: Validations) -> pd.DataFrame:
    """Return mean probability and share of wins per bin, one row a classifier and bin.

    The base rate is left out: it gives all shots of a fold the same probability.
    """
    rows = [
        {"method": name, "shots": count, "probability": probability, "share": share}
        for (outcome, name), result in validations.items()
        if outcome == "wins" and name != "base_rate"
        for count, probability, share in calibration(result.outcome, result.probabilities, BINS)
    ]
    return pd.DataFrame(rows)


def importance_table(shots: Shots, validation: Validation, seed: int) -> pd.DataFrame:
    """Return the decrease of the ROC-AUC by permuted feature, with its most correlated partner."""
    decrease = permutation_importance(
        validation.folds, shots.features, validation.outcome, np.random.default_rng(seed)
    )
    correlation = pd.DataFrame(shots.features).corr("spearman").fillna(0.0).to_numpy(copy=True)
    np.fill_diagonal(correlation, 0.0)
    partner = np.abs(correlation).argmax(axis=1)
    columns = {
        "feature": FEATURES,
        "roc_auc_decrease": decrease.mean(axis=0),
        "std": decrease.std(axis=0),
        "most_correlated": [FEATURES[column] for column in partner],
        "correlation": correlation[np.arange(len(partner)), partner],
    }
    table = pd.DataFrame(columns)
    return table.sort_values("roc_auc_decrease", ascending=False, kind="stable")
