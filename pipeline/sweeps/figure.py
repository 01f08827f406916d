"""Figure of a sweep: the scores of its trials, and the importance of its parameters."""

from collections.abc import Mapping

import pandas as pd
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.ticker import MaxNLocator

from rallygap.pipeline.web.figure_style import FIGURE_WIDTH, MUTED, apply_style

HEIGHT = 3.4  # inch
COMPLETED, PARAMS = "#0f7fc4", "#d55e00"


def sweep_figure(
    trials: pd.DataFrame, importance: Mapping[str, float], score: str, params_score: float | None
) -> Figure:
    """Draw the score of every trial and, if it is known, the importance of the parameters.

    Args:
        trials: columns ``trial``, ``outcome`` and ``score``.
        importance: of the parameters, by name; empty if unknown.
        score: name of the scores.
        params_score: of ``params.yaml``, if known.
    """
    apply_style()
    figure = Figure(figsize=(FIGURE_WIDTH, HEIGHT))
    panels = figure.subplots(1, 2 if importance else 1, squeeze=False)[0]
    _draw_scores(panels[0], trials, score, params_score)
    if importance:
        count = int((trials["outcome"] == "completed").sum())
        _draw_importance(panels[1], importance, count)
    return figure


def _draw_scores(axes: Axes, trials: pd.DataFrame, score: str, params_score: float | None) -> None:
    for outcome, marker, colour, label in (
        ("completed", "o", COMPLETED, "completed"),
        ("pruned", "x", MUTED, "pruned, at its last step"),
    ):
        rows = trials[trials["outcome"] == outcome]
        axes.plot(rows["trial"], rows["score"], marker, color=colour, ms=5, label=label)
    if params_score is not None:
        axes.axhline(params_score, color=PARAMS, lw=1.2, ls="--", label="params.yaml")
    axes.set(xlabel="trial", ylabel=score)
    axes.xaxis.set_major_locator(MaxNLocator(integer=True))
    axes.legend(fontsize=8)


def _draw_importance(axes: Axes, importance: Mapping[str, float], count: int) -> None:
    names = [name.rpartition(".")[2] for name in importance]
    bars = axes.barh(names, list(importance.values()), color=COMPLETED, height=0.6)
    axes.bar_label(bars, fmt="%.2f", padding=3, fontsize=8)
    axes.invert_yaxis()
    axes.grid(visible=False, axis="y")
    axes.margins(x=0.15)
    axes.set_xlabel(f"importance (PED-ANOVA, n = {count})")
