"""Figures that compare the methods: solved questions by setting, and all rates."""

from collections.abc import Callable, Sequence
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from models.exam.design.questions import BASE, SWEEPS
from models.exam.records import ExamRecord
from models.exam.scoring.rates import answered, interval, rates, solved
from pipeline.exam.tables import SOLVED
from pipeline.io.figure_style import FIGURE_WIDTH, INK
from pipeline.io.report_items import ReportFigure

COLOURS = {
    "rallygap": "#0f7fc4",
    "sindy": "#d55e00",
    "sindy_ensemble": "#b85fa0",
    "evidence_greedy": "#b8860b",
    "identification": "#009988",
}
OTHER_COLOUR = "#7d8791"
# Axis label: keys of the number of trials and of the counted ones.
RATES = {
    "false alarms\non clean sets": ("clean_sets", "false_alarms"),
    "right cause\nat 3 limits": ("distinguishable", "distinguishable_right"),
    "right class\nat 3 limits": ("indistinguishable", "indistinguishable_right"),
    "both of\ntwo causes": ("pairs", "pairs_right"),
    "unknown for\nwithheld effects": ("withheld", "withheld_right"),
    "coverage of\nintervals": ("intervals", "intervals_right"),
}
WIDTH = 0.8  # of all bars of a rate
LOW = 8  # %, a bar too short for its number
TEXT: dict[str, Any] = {"ha": "center", "va": "bottom", "fontsize": 6.5}
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
        caption=f"One setting is varied at a time. {SOLVED} Bands: 95 % intervals.",
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
        colour = COLOURS.get(method, OTHER_COLOUR)
        axes.fill_between(list(shares), low, high, color=colour, alpha=0.15, lw=0)
        axes.plot(list(shares), middle, "o-", ms=3.5, color=colour, label=_title(method))


def methods_figure(records: Sequence[ExamRecord], methods: Sequence[str]) -> ReportFigure:
    """Return all rates and the closed share of the removable gap, one bar a method."""
    figure = Figure(figsize=(FIGURE_WIDTH, 3.4))
    axes = figure.subplots()
    width = WIDTH / max(len(methods), 1)
    for number, method in enumerate(methods):
        shift = number * width - (WIDTH - width) / 2
        _draw_bars(axes, rates(records, method), shift, width, method)
    names = [*RATES, "removable\ngap closed"]
    axes.set_xticks(range(len(names)), names, fontsize=7.5)
    axes.set(ylabel="share (%)", ylim=(0, 108))
    axes.grid(visible=False, axis="x")
    _add_legend(figure, axes)
    return ReportFigure(
        figure,
        "methods",
        title="All rates by method",
        caption="The methods answer the same questions from the same recordings, the others a "
        "sample of them. Whiskers: 95 % intervals. A dash: no such answers.",
    )


def _draw_bars(axes: Axes, found: dict[str, Any], shift: float, width: float, method: str) -> None:
    colour = COLOURS.get(method, OTHER_COLOUR)
    closed = found["removable_closed"]
    axes.bar(len(RATES) + shift, 100 * max(closed or 0.0, 0.0), width, color=colour)
    _write(axes, len(RATES) + shift, None if closed is None else 100 * closed)
    for place, (trials, counted) in enumerate(RATES.values()):
        share = 100 * found[counted] / found[trials] if found[trials] else None
        label = _title(method) if place == 0 else None
        axes.bar(place + shift, share or 0.0, width, color=colour, label=label)
        if share is not None:
            low, high = (100 * end for end in interval(found[counted], found[trials]))
            axes.plot([place + shift] * 2, [low, high], color=INK, lw=0.9)
        _write(axes, place + shift, share)


def _write(axes: Axes, place: float, share: float | None) -> None:
    """Write a share into its bar, or above a low one."""
    if share is not None and share > LOW:
        axes.text(place, 1.5, f"{share:.0f}", color="white", **TEXT)
    else:
        axes.text(place, (share or 0.0) + 1.5, "–" if share is None else f"{share:.1f}", **TEXT)


def _title(method: str) -> str:
    return method.replace("_", " ")


def _add_legend(figure: Figure, axes: Axes) -> None:
    handles, labels = axes.get_legend_handles_labels()
    if handles:
        figure.legend(handles, labels, loc="outside upper left", ncols=len(handles))
