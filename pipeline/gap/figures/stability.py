"""Verdicts on many cases in pictures: how far gaps close, and whether causes come again."""

from collections.abc import Sequence

from matplotlib.axes import Axes
from matplotlib.figure import Figure

from pipeline.gap.cases import Diagnosed
from pipeline.gap.figures.verdict import HIDDEN, ROW_HEIGHT, draw_departure, draw_errors
from pipeline.gap.wording import label
from pipeline.io.figure_style import FIGURE_WIDTH, INK

HEADROOM = 1.3  # inch, for titles, the axis and the legend
SPREAD = 0.5  # of the marks of a row, which are 1 apart


def closing_figure(found: Sequence[Diagnosed]) -> Figure:
    """Draw the errors over the horizon, a panel a simulator and a line a split.

    Args:
        found: verdicts on the shots of one source.
    """
    simulators = list(dict.fromkeys(one.case.begun for one in found))
    figure = Figure(figsize=(FIGURE_WIDTH, 3.6))
    panels = figure.subplots(1, len(simulators), sharey=True, squeeze=False)[0]
    for axes, simulator in zip(panels, simulators, strict=True):
        for one in found:
            if one.case.begun == simulator and one.verdict.gap:
                draw_errors(axes, one.verdict.gap)
        axes.set(title=_words(simulator), xlabel="prediction horizon (ms)")
    panels[0].set_ylim(bottom=0)
    panels[0].set_ylabel("position error (mm)")
    _add_legend(figure, panels)
    return figure


def stability_figure(found: Sequence[Diagnosed]) -> Figure:
    """Draw how far every cause lies from the simulator, a panel a simulator and a mark a split.

    Args:
        found: verdicts on the shots of one source, at least one with a cause.
    """
    simulators = list(dict.fromkeys(one.case.begun for one in found))
    names = list(dict.fromkeys(label(cause) for one in found for cause in one.verdict.effects))
    figure = Figure(figsize=(FIGURE_WIDTH, HEADROOM + ROW_HEIGHT * len(names) / 1.6))
    panels = figure.subplots(1, len(simulators), sharex=True, sharey=True, squeeze=False)[0]
    for axes, simulator in zip(panels, simulators, strict=True):
        own = [one for one in found if one.case.begun == simulator]
        _draw_causes(axes, own, names)
        axes.set(title=_words(simulator), xlabel="departure (detectable sizes)")
    panels[0].set_yticks(range(len(names)), names)
    panels[0].set_ylim(len(names) - 0.5, -0.5)
    _add_legend(figure, panels)
    return figure


def _draw_causes(axes: Axes, found: Sequence[Diagnosed], names: Sequence[str]) -> None:
    axes.axvspan(-1, 1, color=HIDDEN, lw=0, label="might stay hidden")
    axes.axvline(0, color=INK, lw=1)
    for place, one in enumerate(found):
        offset = SPREAD * ((place + 0.5) / len(found) - 0.5)
        for cause in one.verdict.effects:
            row = names.index(label(cause)) + offset
            draw_departure(axes, row, cause, line=2, mark=4)
    axes.set_xscale("symlog", linthresh=1.0, linscale=0.3)
    axes.xaxis.set_major_formatter("{x:g}")
    axes.grid(axis="y", visible=False)


def _add_legend(figure: Figure, panels: Sequence[Axes]) -> None:
    legends = [zip(*axes.get_legend_handles_labels(), strict=True) for axes in panels]
    unique = {name: handle for legend in legends for handle, name in legend}
    figure.legend(unique.values(), unique.keys(), loc="outside upper left", ncols=3)


def _words(name: str) -> str:
    return name.replace("_", " ")
