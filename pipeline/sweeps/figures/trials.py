"""How a sweep went, and which parameters mattered."""

from collections.abc import Mapping

import numpy as np
import pandas as pd
from matplotlib.figure import Figure

from pipeline.io.figure_style import FIGURE_WIDTH, MUTED
from pipeline.sweeps.settings import PolicySweep, PredictorSweep

FINISHED, GIVEN_UP, BEST = "#0f7fc4", "#7d8791", "#d55e00"


def history_figure(trials: pd.DataFrame, settings: PredictorSweep | PolicySweep) -> Figure:
    """Draw the score of every trial, and the best so far.

    Args:
        trials: one row a trial: trial, outcome and score.
        settings: of the sweep: which score, and whether less of it is better.
    """
    figure = Figure(figsize=(FIGURE_WIDTH, 3.4))
    axes = figure.add_subplot()
    finished = trials[trials["outcome"] == "finished"]
    given_up = trials[trials["outcome"] == "given up"]
    axes.plot(given_up["trial"], given_up["score"], "o", color=GIVEN_UP, mfc="none", ms=4,
              label=f"given up (last {settings.step})")  # fmt: skip
    axes.plot(finished["trial"], finished["score"], "o", color=FINISHED, ms=4, label="finished")
    running = np.minimum if settings.direction == "minimize" else np.maximum
    best = running.accumulate(finished["score"].to_numpy(dtype=np.float64))
    axes.step(finished["trial"], best, where="post", color=BEST, label="best so far")
    axes.set(xlabel="trial", ylabel=settings.score)
    axes.locator_params(axis="x", integer=True)
    axes.legend(loc="upper center", bbox_to_anchor=(0.5, 1.15), ncols=3)
    return figure


def importance_figure(importances: Mapping[str, float]) -> Figure:
    """Draw the share of each parameter in how scores vary, the largest on top.

    Args:
        importances: by dotted name.
    """
    ordered = sorted(importances.items(), key=lambda item: item[1])
    names = [name.rpartition(".")[2].replace("_", " ") for name, _ in ordered]
    figure = Figure(figsize=(FIGURE_WIDTH, 1.0 + 0.3 * len(names)))
    axes = figure.add_subplot()
    axes.barh(names, [100 * share for _, share in ordered], color=FINISHED, height=0.6)
    axes.grid(axis="y", visible=False)
    axes.tick_params(axis="y", length=0, labelcolor=MUTED)
    axes.set(xlabel="share of importance (%)", xlim=(0, None))
    return figure
