"""Figures of many verdicts: prediction errors, and how well causes agree between splits."""

from collections.abc import Sequence

from matplotlib.axes import Axes
from matplotlib.figure import Figure

from pipeline.gap.cases import Diagnosed
from pipeline.gap.figures.verdict import (
    ROW_HEIGHT,
    draw_departure,
    draw_errors,
    shade_undetectable,
)
from pipeline.io.figure_style import FIGURE_WIDTH
from pipeline.io.report_items import ReportFigure

HEADROOM = 1.3  # inch, for titles, the axis and the legend
SPREAD = 0.5  # of the marks of a row, which are 1 apart


def closing_figure(diagnosed: Sequence[Diagnosed]) -> ReportFigure:
    """Draw the errors over the horizon, a panel per simulator and a line per split.

    Args:
        diagnosed: verdicts on the shots of one source.
    """
    source, simulators = _source(diagnosed), _simulators(diagnosed)
    figure = Figure(figsize=(FIGURE_WIDTH, 3.6))
    panels = figure.subplots(1, len(simulators), sharey=True, squeeze=False)[0]
    for axes, simulator in zip(panels, simulators, strict=True):
        for one in diagnosed:
            if one.case.simulator_name == simulator and one.verdict.gap:
                draw_errors(axes, one.verdict.gap)
        axes.set(title=_title(simulator), xlabel="prediction horizon (ms)")
    panels[0].set_ylim(bottom=0)
    panels[0].set_ylabel("position error (mm)")
    _add_legend(figure, panels)
    return ReportFigure(
        figure,
        f"errors_{source}",
        title=f"Prediction error on {source} before and after",
        caption="Root mean square error over the prediction horizon on held-out shots, with the "
        "nominal and the amended simulator; prediction floor: error of a correct simulator. One "
        "line per split; bands: 95 %, bootstrap over shots.",
    )


def stability_figure(diagnosed: Sequence[Diagnosed]) -> ReportFigure:
    """Draw the departure of every cause, a panel per simulator and a mark per split.

    Args:
        diagnosed: verdicts on the shots of one source, at least one with a cause.
    """
    source, simulators = _source(diagnosed), _simulators(diagnosed)
    names = list(dict.fromkeys(one.identity for of in diagnosed for one in of.verdict.causes))
    figure = Figure(figsize=(FIGURE_WIDTH, HEADROOM + ROW_HEIGHT * len(names) / 1.6))
    panels = figure.subplots(1, len(simulators), sharex=True, sharey=True, squeeze=False)[0]
    for axes, simulator in zip(panels, simulators, strict=True):
        _draw_causes(axes, [d for d in diagnosed if d.case.simulator_name == simulator], names)
        axes.set(title=_title(simulator), xlabel="estimate − simulator (min. detectable effects)")
    panels[0].set_yticks(range(len(names)), names)
    panels[0].set_ylim(len(names) - 0.5, -0.5)
    _add_legend(figure, panels)
    return ReportFigure(
        figure,
        f"causes_{source}",
        title=f"Causes of the gap to {source}",
        caption="Estimates with 95 % intervals, one mark per split, less the simulator's value, in "
        "minimum detectable effects (5.8 standard errors with the simulator's own parameters "
        "free); causes without one are not drawn. The axis is linear in the shaded band and "
        "logarithmic beyond.",
    )


def _draw_causes(axes: Axes, diagnosed: Sequence[Diagnosed], names: Sequence[str]) -> None:
    shade_undetectable(axes)
    for place, one in enumerate(diagnosed):
        offset = SPREAD * ((place + 0.5) / len(diagnosed) - 0.5)
        for cause in one.verdict.causes:
            row = names.index(cause.identity) + offset
            draw_departure(axes, row, cause, one.verdict, line=2, mark=4)
    axes.set_xscale("symlog", linthresh=1.0, linscale=0.3)
    axes.xaxis.set_major_formatter("{x:g}")
    axes.grid(axis="y", visible=False)


def _add_legend(figure: Figure, panels: Sequence[Axes]) -> None:
    legends = [zip(*axes.get_legend_handles_labels(), strict=True) for axes in panels]
    unique = {name: handle for legend in legends for handle, name in legend}
    figure.legend(unique.values(), unique.keys(), loc="outside upper left", ncols=3)


def _source(diagnosed: Sequence[Diagnosed]) -> str:
    return diagnosed[0].case.source


def _simulators(diagnosed: Sequence[Diagnosed]) -> list[str]:
    return list(dict.fromkeys(one.case.simulator_name for one in diagnosed))


def _title(name: str) -> str:
    return name.replace("_", " ")
