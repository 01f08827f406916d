"""Learning curves."""

import pandas as pd
from matplotlib.figure import Figure

from rallygap.pipeline.io.figure_style import FIGURE_WIDTH, predictor_colour
from rallygap.pipeline.io.labels import predictor_label

COLUMNS = 3


def training_figure(curves: pd.DataFrame) -> Figure:
    """Draw training and validation loss over the epochs, one panel per predictor.

    Args:
        curves: one row an epoch: predictor, epoch, training, validation.
    """
    names = list(curves["predictor"].unique())
    columns = min(len(names), COLUMNS)
    rows = -(-len(names) // columns)
    figure = Figure(figsize=(FIGURE_WIDTH, 2.8 * rows))
    axes = figure.subplots(rows, columns, squeeze=False, sharey=True)
    for spare in axes.flat[len(names) :]:
        spare.remove()
    for panel, name in zip(axes.flat, names, strict=False):
        curve = curves[curves["predictor"] == name]
        colour = predictor_colour(name)
        panel.plot(curve["epoch"], curve["training"], color=colour, label="training")
        panel.plot(curve["epoch"], curve["validation"], color=colour, ls="--", label="validation")
        panel.set(title=predictor_label(name), xlabel="epoch", yscale="log")
        panel.legend()
    for panel in axes[:, 0]:
        panel.set_ylabel("mean squared error (normalised)")
    return figure
