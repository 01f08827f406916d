"""The report of train_predictor: learning curves, final losses and metrics."""

from typing import Any

import pandas as pd

from rallygap.pipeline.io.metrics import nested
from rallygap.pipeline.io.report_items import ReportFigure, ReportItem, ReportTable
from rallygap.pipeline.predictors.figures.training import training_figure

COLUMNS = ["predictor", "epoch", "training", "validation"]
FINAL = ["predictor", "training", "validation"]


def training_items(curves: pd.DataFrame) -> list[ReportItem]:
    """Return the learning curves and the losses after the last epoch.

    Args:
        curves: one row per predictor and epoch, with ``COLUMNS``.
    """
    return [
        ReportFigure(
            training_figure(curves),
            "training",
            title="Training",
            caption="Training and validation loss after each epoch: mean squared error of the "
            "normalised states over the horizon. Validation windows are not trained on and select "
            "nothing: the weights of the last epoch are kept. Most of the remaining loss is the "
            "noise of the measured spin.",
        ),
        ReportTable(
            curves.groupby("predictor", sort=False).tail(1)[COLUMNS],
            "training",
            title="Loss after the last epoch",
            caption="Mean squared error of the normalised states.",
        ),
    ]


def training_metrics(curves: pd.DataFrame) -> dict[str, Any]:
    """Return ``{predictor: {training, validation}}``, the losses after the last epoch."""
    return nested(curves.groupby("predictor", sort=False).tail(1)[FINAL], ["predictor"])
