"""Figures of many verdicts: prediction errors, and how well causes agree between splits."""

from collections.abc import Sequence

from matplotlib.axes import Axes
from matplotlib.figure import Figure

from rallygap.models.gap.verdict import Cause, Verdict
from rallygap.pipeline.gap.cases import Diagnosed
from rallygap.pipeline.gap.figures.verdict import (
    ROW_HEIGHT,
    add_legend,
    draw_departure,
    draw_errors,
    shade_undetectable,
)
from rallygap.pipeline.io.figure_style import FIGURE_WIDTH
from rallygap.pipeline.io.labels import simulator_label
from rallygap.pipeline.io.report_items import ReportFigure

HEADROOM = 1.3  # inch, for titles, the axis and the legend
SPREAD = 0.5  # of the marks of a row, which are 1 apart


def closing_figure(diagnosed: Sequence[Diagnosed]) -> ReportFigure:
    """Draw the errors on one source, a panel per simulator and a line per split."""
    source, simulators = diagnosed[0].case.source, _simulators(diagnosed)
    figure = Figure(figsize=(FIGURE_WIDTH, 3.6))
    panels = figure.subplots(1, len(simulators), sharey=True, squeeze=False)[0]
    for axes, simulator in zip(panels, simulators, strict=True):
        for diagnosis in diagnosed:
            if diagnosis.case.simulator_name == simulator and diagnosis.verdict.gap:
                draw_errors(axes, diagnosis.verdict.gap)
        axes.set(title=simulator_label(simulator), xlabel="prediction horizon (ms)")
    panels[0].set_ylim(bottom=0)
    panels[0].set_ylabel("position error (mm)")
    add_legend(figure)
    return ReportFigure(
        figure,
        f"errors_{source}",
        title=f"Prediction error on {source} before and after",
        caption="Root mean square error over the prediction horizon on held-out shots, with the "
        "nominal and the amended simulator; prediction floor: error of a correct simulator. One "
        "line per split; bands: 95 %, bootstrap over shots.",
    )


def stability_figure(diagnosed: Sequence[Diagnosed]) -> ReportFigure:
    """Draw the detectable causes on one source, a panel per simulator and a mark per split."""
    source, simulators = diagnosed[0].case.source, _simulators(diagnosed)
    names = list(
        dict.fromkeys(c.identity for one in diagnosed for c in detectable_causes(one.verdict))
    )
    figure = Figure(figsize=(FIGURE_WIDTH, HEADROOM + ROW_HEIGHT * len(names) / 1.6))
    panels = figure.subplots(1, len(simulators), sharex=True, sharey=True, squeeze=False)[0]
    for axes, simulator in zip(panels, simulators, strict=True):
        _draw_causes(axes, [d for d in diagnosed if d.case.simulator_name == simulator], names)
        axes.set_title(simulator_label(simulator))
    figure.supxlabel("estimate − simulator (min. detectable effects)", fontsize="medium")
    panels[0].set_yticks(range(len(names)), names)
    panels[0].set_ylim(len(names) - 0.5, -0.5)
    add_legend(figure)
    return ReportFigure(
        figure,
        f"causes_{source}",
        title=f"Leading causes of the gap to {source}",
        caption="Estimates with 95 % intervals, one mark per split, less the simulator's value, in "
        "minimum detectable effects (5.8 standard errors with the simulator's own parameters "
        "free); causes without one are left out. The axis is linear in the shaded band and "
        "logarithmic beyond.",
    )


def detectable_causes(verdict: Verdict) -> list[Cause]:
    """Return the leading causes with a minimum detectable effect, the unit of the figure."""
    return [cause for cause in verdict.leading if cause.identity in verdict.minimum_detectable]


def _draw_causes(axes: Axes, diagnosed: Sequence[Diagnosed], names: Sequence[str]) -> None:
    shade_undetectable(axes)
    for place, diagnosis in enumerate(diagnosed):
        offset = SPREAD * ((place + 0.5) / len(diagnosed) - 0.5)
        for cause in detectable_causes(diagnosis.verdict):
            row = names.index(cause.identity) + offset
            draw_departure(axes, row, cause, diagnosis.verdict, line=2, mark=4)
    axes.set_xscale("symlog", linthresh=1.0, linscale=0.3)
    axes.xaxis.set_major_formatter("{x:g}")
    axes.grid(axis="y", visible=False)


def _simulators(diagnosed: Sequence[Diagnosed]) -> list[str]:
    return list(dict.fromkeys(diagnosis.case.simulator_name for diagnosis in diagnosed))
