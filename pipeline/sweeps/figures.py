"""Figures of a sweep: scores of all trials, and importance of the parameters."""

from collections.abc import Mapping

import numpy as np
import pandas as pd
from matplotlib.figure import Figure

from pipeline.io.figure_style import FIGURE_WIDTH, MUTED
from pipeline.sweeps.settings import PolicySweep, PredictorSweep

COMPLETED, PRUNED, BEST = "#0f7fc4", "#7d8791", "#d55e00"


def history_figure(trials: pd.DataFrame, settings: PredictorSweep | PolicySweep) -> Figure:
    """Draw the score of every trial, and the best so far; columns trial, outcome and score."""
    figure = Figure(figsize=(FIGURE_WIDTH, 3.4))
    axes = figure.add_subplot()
    completed, pruned = (trials[trials["outcome"] == name] for name in ("completed", "pruned"))
    axes.plot(pruned["trial"], pruned["score"], "o", color=PRUNED, mfc="none", ms=4,
              label=f"pruned (last {settings.step})")  # fmt: skip
    axes.plot(completed["trial"], completed["score"], "o", color=COMPLETED, ms=4, label="completed")
    better = np.minimum if settings.direction == "minimize" else np.maximum
    best = better.accumulate(completed["score"].to_numpy(dtype=np.float64))
    axes.step(completed["trial"], best, where="post", color=BEST, label="best so far")
    axes.set(xlabel="trial", ylabel=settings.score)
    axes.locator_params(axis="x", integer=True)
    axes.legend(loc="upper center", bbox_to_anchor=(0.5, 1.15), ncols=3)
    return figure


def importance_figure(importances: Mapping[str, float]) -> Figure:
    """Draw the importance of each parameter by dotted name, the largest on top."""
    ordered = sorted(importances.items(), key=lambda item: item[1])
    names = [name.rpartition(".")[2].replace("_", " ") for name, _ in ordered]
    figure = Figure(figsize=(FIGURE_WIDTH, 1.0 + 0.3 * len(names)))
    axes = figure.add_subplot()
    axes.barh(names, [100 * share for _, share in ordered], color=COMPLETED, height=0.6)
    axes.grid(axis="y", visible=False)
    axes.tick_params(axis="y", length=0, labelcolor=MUTED)
    axes.set(xlabel="share of importance (%)", xlim=(0, None))
    return figure
