"""The report of `train_predictor`: learning curves and final losses."""

from collections.abc import Iterator

import pandas as pd
from matplotlib.figure import Figure

from rallygap.pipeline.runtime.stage_run import StageRun
from rallygap.pipeline.web.figure_style import FIGURE_WIDTH, predictor_colour
from rallygap.pipeline.web.labels import predictor_label
from rallygap.pipeline.web.report_items import ReportFigure, ReportItem, ReportTable

PANELS = 3  # in a row
COLUMNS = ["predictor", "epoch", "training", "validation"]


def items(run: StageRun) -> Iterator[ReportItem]:
    """Yield the learning curves and the losses after the last epoch."""
    curves = run.kept("train_predictor", "losses")
    yield ReportFigure(
        training_figure(curves),
        "training",
        title="Training",
        caption="Training and validation loss after each epoch: mean squared error of the "
        "normalised states over the horizon. Validation windows are not trained on and select "
        "nothing: the weights of the last epoch are kept. Most of the remaining loss is the "
        "noise of the measured spin.",
    )
    yield ReportTable(
        curves.groupby("predictor", sort=False).tail(1)[COLUMNS],
        "training",
        title="Loss after the last epoch",
        caption="Mean squared error of the normalised states.",
    )


def training_figure(curves: pd.DataFrame) -> Figure:
    """Draw training and validation loss over the epochs, one panel per predictor.

    Args:
        curves: one row an epoch: predictor, epoch, training, validation.
    """
    names = list(curves["predictor"].unique())
    columns = min(len(names), PANELS)
    rows = -(-len(names) // columns)
    figure = Figure(figsize=(FIGURE_WIDTH, 2.8 * rows))
    grid = figure.subplots(rows, columns, squeeze=False, sharey=True)
    for spare in grid.flat[len(names) :]:
        spare.remove()
    for axes, name in zip(grid.flat, names, strict=False):
        curve = curves[curves["predictor"] == name]
        for loss, dashes in (("training", "-"), ("validation", "--")):
            axes.plot(curve["epoch"], curve[loss], dashes, color=predictor_colour(name), label=loss)
        axes.set(title=predictor_label(name), xlabel="epoch", yscale="log")
        axes.legend()
    for axes in grid[:, 0]:
        axes.set_ylabel("mean squared error (normalised)")
    return figure
