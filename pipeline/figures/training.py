"""Learning curves."""

import pandas as pd
from matplotlib.figure import Figure

from pipeline.figures.style import FIGURE_WIDTH, predictor_colour


def training_figure(curves: pd.DataFrame) -> Figure:
    """Draw the loss of training and validation over the epochs, one panel a predictor.

    Args:
        curves: one row an epoch: predictor, epoch, training, validation.
    """
    names = list(curves["predictor"].unique())
    figure = Figure(figsize=(FIGURE_WIDTH, 2.8))
    axes = figure.subplots(1, len(names), squeeze=False, sharey=True)[0]
    for panel, name in zip(axes, names, strict=True):
        curve = curves[curves["predictor"] == name]
        colour = predictor_colour(name)
        panel.plot(curve["epoch"], curve["training"], color=colour, label="training")
        panel.plot(curve["epoch"], curve["validation"], color=colour, ls="--", label="validation")
        panel.set(title=name.replace("_", " "), xlabel="epoch", yscale="log")
        panel.legend()
    axes[0].set_ylabel("loss")
    return figure
