"""Figures of an audit."""

import numpy as np
from matplotlib.figure import Figure

from rallygap.models.audit.audit import Audit
from rallygap.models.audit.bounces import SHELL, SOLID, Bounces
from rallygap.pipeline.web.figure_style import FIGURE_WIDTH, MUTED
from rallygap.pipeline.web.report_items import ReportFigure

COLOUR = "#0f7fc4"
LEAST = 0.6  # restitution from which the axis begins, at least
ROW, HEADROOM = 0.35, 1.0  # inch


def worth_figure(audit: Audit) -> ReportFigure:
    """Draw what each effect is worth, that is not of every engine; there is at least one."""
    shown = [effect for effect in audit.effects if np.isfinite(effect.worth_mm)]
    shown.sort(key=lambda effect: effect.worth_mm)
    figure = Figure(figsize=(FIGURE_WIDTH, HEADROOM + ROW * len(shown)))
    axes = figure.subplots()
    names = [effect.hypothesis.identity for effect in shown]
    axes.barh(names, [effect.worth_mm for effect in shown], 0.6, color=COLOUR)
    axes.set_xscale("symlog", linthresh=0.1)
    axes.set_xlim(left=0.0)
    axes.set_xlabel("distance without the effect (mm)")
    axes.grid(axis="y", visible=False)
    return ReportFigure(
        figure,
        "worth",
        title="What each effect is worth",
        caption="By how much the distance from the engine grows without an effect, the others "
        "fitted again: median over the probes, 0.4 s after the start of a flight, and 0.15 s "
        "after that of a bounce.",
    )


def bounces_figure(bounces: Bounces) -> ReportFigure:
    """Draw restitution and grip of every bounce."""
    figure = Figure(figsize=(FIGURE_WIDTH, 3.0))
    left, right = figure.subplots(1, 2)
    left.plot(bounces.speed, bounces.restitution, "o", markersize=3, color=COLOUR)
    left.set_xlabel("normal speed before (m/s)")
    left.set_ylabel("restitution")
    left.set_ylim(min(LEAST, 0.95 * np.nanmin(bounces.restitution)), 1.05)
    right.plot(bounces.slip, bounces.grip, "o", markersize=3, color=COLOUR)
    for share, label in ((SHELL, "a shell rolls"), (SOLID, "a solid sphere rolls")):
        right.axhline(share, color=MUTED, lw=0.9, ls="--")
        right.annotate(label, (1.0, share), xycoords=("axes fraction", "data"), ha="right",
                       va="bottom", color=MUTED, fontsize="small")  # fmt: skip
    right.set_xlabel("slip before (m/s)")
    right.set_ylabel("change of velocity over slip")
    return ReportFigure(
        figure,
        "bounces",
        title="Bounces one by one",
        caption="Restitution, and the change of the velocity along the table over the slip of the "
        "contact point. Below the dashed lines the ball slides, on them it rolls.",
    )
