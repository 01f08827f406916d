"""The report of shot_quality: its tables and figures with their captions, and its metrics."""

from typing import Any

import numpy as np
import pandas as pd

from rallygap.models.shot_quality.shots import Shots
from rallygap.pipeline.io.metrics import nested
from rallygap.pipeline.io.report_items import ReportFigure, ReportItem, ReportTable
from rallygap.pipeline.shot_quality.figures.returns import calibration_figure, medians_figure
from rallygap.pipeline.shot_quality.returns import KEYS, METRICS


def return_items(
    quality: pd.DataFrame, out_of_range: pd.DataFrame, swap: pd.DataFrame
) -> list[ReportItem]:
    """Return the medians of the returns, their ranges and the effect of the swap."""
    caption = (
        "Medians over all successful returns of sim2real, with 95 % intervals bootstrapped over "
        "balls. Speed and spin rate are those just after the racket; clearance is the gap between "
        "ball and net. The winning probability is a random forest's estimate for a professional "
        "of the arena who plays such a shot. Predictors return different balls, so the medians "
        "are of different balls."
    )
    return [
        ReportFigure(
            medians_figure(quality[quality["protocol"] == "every_tick"], METRICS),
            "quality",
            title="Shot quality: medians of four metrics",
            caption=f"{caption} Hatched: the shorter horizons, as in the paper. All predictors "
            "forecast at every control step.",
        ),
        ReportTable(
            quality,
            "quality",
            title="Shot quality",
            caption=f"{caption} returns: mean number over policies. out_of_range: share of the "
            "returns with at least one feature outside the range of the forest's training shots; a "
            "forest does not extrapolate.",
        ),
        ReportTable(
            out_of_range,
            "out_of_range",
            title="Returns outside the range of the training shots",
            caption="Share of the returns with a feature below the smallest or above the largest "
            "value among the training shots. A return may have an unusual combination of features "
            "and lie within all ranges.",
        ),
        ReportTable(
            swap,
            "swap",
            title="Shot quality: effect of the predictor swap",
            caption="The median of a predictor divided by that of physics at every control step: "
            "1 is no change. 95 % intervals are bootstrapped over balls, the same ones for both. "
            "Predictors return different balls, so a ratio compares sets of returns and not "
            "single balls.",
        ),
    ]


def validation_items(
    shots: Shots,
    folds: int,
    scores: pd.DataFrame,
    calibration: pd.DataFrame,
    importance: pd.DataFrame,
) -> list[ReportItem]:
    """Return how well winning probabilities are estimated on held-out matches."""
    caption = (
        f"{len(shots)} good returns of professionals in {len(np.unique(shots.matches))} matches, "
        f"each evaluated by a model trained without its match "
        f"({folds} folds). "
    )
    return [
        ReportFigure(
            calibration_figure(calibration, float(shots.wins.mean())),
            "calibration",
            title="Calibration of the winning probability",
            caption=f"{caption}Each point is an eighth of the shots, sorted by probability.",
        ),
        ReportTable(calibration, "calibration", title="Calibration", caption=caption),
        ReportTable(
            scores,
            "scores",
            title="Classification of winning shots",
            caption=f"{caption}outcome wins: this shot won the point, which the forest estimates; "
            "point: its player won the point in the end, which later shots decide. share: of the "
            "shots with that outcome. ROC-AUC: 0.5 is uninformative; the base rate is slightly "
            "below because it is that of the other matches. Brier score: smaller is better. 95 % "
            "intervals (low, high) are bootstrapped over matches.",
        ),
        ReportTable(
            importance,
            "importance",
            title="Permutation importance of the forest's features",
            caption=f"{caption}Decrease of the ROC-AUC when a feature is permuted among shots: "
            "mean and standard deviation of five permutations. Correlated features share their "
            "importance, so each seems to matter less than it does. most_correlated: the feature "
            "with the strongest rank correlation.",
        ),
    ]


def receiver_items(points: int, receivers: pd.DataFrame, medians: pd.DataFrame) -> list[ReportItem]:
    """Return how winning probabilities depend on the receiver."""
    caption = (
        f"Forests trained on {points} simulated points each, between professionals and a "
        "receiver whose reach or errors are a third smaller or larger, in another arena. Only "
        "shots of the unchanged player count."
    )
    return [
        ReportTable(
            receivers,
            "receivers",
            title="Sensitivity to the receiver",
            caption=f"{caption} reach, error: factors. win_rate: share of the shots that won. "
            "order_agreement: share of the pairs of predictors, on the same set and horizons, "
            "whose medians have the same order as with the nominal receiver. nominal_repeat: the "
            "nominal receiver on other points, which shows the effect of chance alone.",
        ),
        ReportTable(
            medians.reset_index(),
            "win_probability",
            title="Winning probabilities with other receivers and labels",
            caption=f"Medians over the returns. {caption} as_measured: the forest of the other "
            "tables. point: the same shots, labelled by who won the point in the end.",
        ),
    ]


def metrics(quality: pd.DataFrame, scores: pd.DataFrame, receivers: pd.DataFrame) -> dict[str, Any]:
    """Return the values of the tables by their keys, without those that are not finite."""
    return {
        "returns": nested(quality, KEYS),
        "scores": nested(scores, ["outcome", "method"]),
        "receivers": nested(receivers, ["receiver"]),
    }
