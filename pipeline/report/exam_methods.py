"""Figures that compare the methods: solved questions by setting, and all rates."""

from collections.abc import Callable, Sequence
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from rallygap.models.exam.design.questions import BASE, SWEEPS
from rallygap.models.exam.records import ExamRecord
from rallygap.models.exam.scoring.rates import answered, interval, rates, solved
from rallygap.pipeline.report.exam_tables import SOLVED
from rallygap.pipeline.web.figure_style import FIGURE_WIDTH
from rallygap.pipeline.web.labels import method_label
from rallygap.pipeline.web.report_items import ReportFigure

COLOURS = {
    "rallygap": "#0f7fc4",
    "sindy": "#d55e00",
    "sindy_ensemble": "#b85fa0",
    "evidence_greedy": "#b8860b",
    "identification": "#009988",
}
# Axis label: keys of the number of trials and of the counted ones.
RATES = {
    "false alarms\non clean sets": ("clean_sets", "false_alarms"),
    "right cause\nat 3 limits": ("distinguishable", "distinguishable_right"),
    "right class\nat 3 limits": ("indistinguishable", "indistinguishable_right"),
    "both of\ntwo causes": ("pairs", "pairs_right"),
    "unknown for\nwithheld effects": ("withheld", "withheld_right"),
    "coverage of\nintervals": ("intervals", "intervals_right"),
}
WIDTH = 0.6  # of all marks of a rate
APART = 1.03  # factor between the places of two methods on a logarithmic axis
CELLS = (BASE, *SWEEPS)
Setting = Callable[[Any], float]  # of a cell
PANELS: dict[str, Setting] = {
    "size (detection limits)": lambda cell: cell.multiple,
    "number of shots": lambda cell: cell.shots,
    "noise of a coordinate (mm)": lambda cell: 1000 * cell.noise,
}


def accuracy_figure(records: Sequence[ExamRecord], methods: Sequence[str]) -> ReportFigure:
    """Return the share of solved questions of the sweeps, against size, shots and noise."""
    figure = Figure(figsize=(FIGURE_WIDTH, 3.2))
    grid = figure.subplots(1, len(PANELS), sharey=True)
    for axes, (label, setting) in zip(grid, PANELS.items(), strict=True):
        cells = [cell for cell in CELLS if cell is BASE or setting(cell) != setting(BASE)]
        cells.sort(key=setting)
        for method in methods:
            _draw_line(axes, records, method, {cell.name: setting(cell) for cell in cells})
        axes.set(xlabel=label, xscale="log", ylim=(0, 103))
        ticks = [setting(cell) for cell in cells]
        axes.set_xticks(ticks, [f"{tick:g}" for tick in ticks])
        axes.minorticks_off()
    grid[0].set_ylabel("solved questions (%)")
    _add_legend(figure, grid[0])
    return ReportFigure(
        figure,
        "accuracy",
        title="Solved questions by size, number of shots and noise",
        caption=f"One setting is varied at a time. {SOLVED} Whiskers: 95 % intervals. Marks of "
        "the methods are shifted a little, so that these can be distinguished.",
    )


def _draw_line(
    axes: Axes, records: Sequence[ExamRecord], method: str, settings: dict[str, float]
) -> None:
    shares: dict[float, tuple[float, float, float]] = {}
    for cell, setting in settings.items():
        given = answered([record for record in records if record.cell == cell], method)
        if given:
            right = sum(solved(record, method) for record in given)
            shares[setting] = (right / len(given), *interval(right, len(given)))
    if shares:
        middle, low, high = 100 * np.array(list(shares.values())).T
        colour, apart = COLOURS[method], APART ** list(COLOURS).index(method)
        places = np.array(list(shares)) * apart
        ends = [middle - low, high - middle]
        axes.errorbar(
            places, middle, ends, fmt="o-", ms=3.5, lw=1.4, elinewidth=0.8, color=colour,
            label=method_label(method),
        )  # fmt: skip


def methods_figure(records: Sequence[ExamRecord], methods: Sequence[str]) -> ReportFigure:
    """Return all rates and the closed share of the removable gap, one mark a method."""
    figure = Figure(figsize=(FIGURE_WIDTH, 3.4))
    axes = figure.subplots()
    for number, method in enumerate(methods):
        shift = WIDTH * ((number + 0.5) / len(methods) - 0.5)
        _draw_rates(axes, rates(records, method), shift, method)
    names = [*RATES, "removable\ngap closed"]
    axes.set_xticks(range(len(names)), names, fontsize=7.5)
    axes.set(ylabel="share (%)", ylim=(-2, 103))
    axes.grid(visible=False, axis="x")
    _add_legend(figure, axes)
    return ReportFigure(
        figure,
        "methods",
        title="All rates by method",
        caption="The methods answer the same questions from the same recordings, the others a "
        "sample of them. Whiskers: 95 % intervals. Where there is no mark, there are no answers.",
    )


def _draw_rates(axes: Axes, found: dict[str, Any], shift: float, method: str) -> None:
    style: dict[str, Any] = {"color": COLOURS[method], "ms": 4}
    if found["removable_closed"] is not None:
        axes.plot(len(RATES) + shift, 100 * max(found["removable_closed"], 0.0), "o", **style)
    axes.plot([], [], "o", label=method_label(method), **style)
    for place, (trials, counted) in enumerate(RATES.values()):
        if not found[trials]:
            continue
        share = 100 * found[counted] / found[trials]
        low, high = (100 * end for end in interval(found[counted], found[trials]))
        ends = [[share - low], [high - share]]
        axes.errorbar(place + shift, share, ends, fmt="o", elinewidth=0.9, **style)


def _add_legend(figure: Figure, axes: Axes) -> None:
    handles, labels = axes.get_legend_handles_labels()
    if handles:
        figure.legend(handles, labels, loc="outside upper left", ncols=len(handles))
