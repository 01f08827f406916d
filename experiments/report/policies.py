"""Figures of the experiments on policies: spreads of forecasts, and the predictor swap."""

from collections.abc import Iterator

import numpy as np
import pandas as pd
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.image import AxesImage
from matplotlib.patches import Patch, Rectangle

from rallygap.pipeline.report.plots import add_legend, ahead, label_rows, percent, sample
from rallygap.pipeline.runtime.stage_run import StageRun
from rallygap.pipeline.transfer.returns import PROTOCOLS
from rallygap.pipeline.web.figure_style import (
    FIGURE_WIDTH,
    INK,
    MUTED,
    predictor_colour,
    predictor_order,
)
from rallygap.pipeline.web.labels import predictor_label
from rallygap.pipeline.web.report_items import ReportFigure

# What policies learn from and observe: label, marker and colour.
POLICIES = {
    "exact": ("learned from exact forecasts", "o", MUTED),
    "filtered": ("learned from a filter's forecasts", "s", "#0f7fc4"),
    "filtered_with_spread": ("observes their spread, too", "D", "#d55e00"),
}
READINGS = {"first_window": ("o", -0.16), "every_tick": ("s", 0.16)}  # marker, shift in its row
STEP = 5  # points; the colour scale ends at a multiple
DARK = 0.6  # share of the scale beyond which text is white
OBSERVED = {"intercept": "intercept features", "strict": "the paper's inputs"}


def spread_policies(run: StageRun) -> Iterator[ReportFigure]:
    """Yield return rates of policies that observe spreads, and of others."""
    yield ReportFigure(
        spread_policies_figure(run.published("spread_policies", "rates")),
        "rates",
        title="Policies that observe how sure forecasts are",
        caption="Return rates on the shots of sim2real, with 95 % intervals over trainings and "
        "recordings.",
    )


def swap_study(run: StageRun) -> Iterator[ReportFigure]:
    """Yield return rates under both readings of Table I, and the gains of the mechanism."""
    yield ReportFigure(
        readings_figure(run.published("swap_study", "readings_all")),
        "readings",
        title="Return rates by predictor and protocol",
        caption="Policies play the arena's replayed shots, with one forecast from the first window "
        "and with a forecast at every control step. 95 % intervals over trainings and recordings.",
    )
    yield ReportFigure(
        mechanism_figure(run.published("swap_study", "gains_mechanism")),
        "mechanism",
        title="Gains of the swap by the interval and the delay of forecasts",
        caption="Difference of the return rate to that with simulator C, paired by shot.",
    )


def spread_policies_figure(table: pd.DataFrame) -> Figure:
    """Draw return rates with their intervals: a column per set, a row per predictor.

    Args:
        table: one row per ``set``, ``predictor`` and ``policy``, with ``balls``, ``return_rate``,
            ``return_rate_low`` and ``return_rate_high``.
    """
    sets, predictors = list(table["set"].unique()), list(table["predictor"].unique())
    figure = Figure(figsize=(FIGURE_WIDTH, 1.4 + 0.22 * len(predictors) * len(POLICIES)))
    grid = figure.subplots(1, len(sets), sharex=True, sharey=True, squeeze=False)[0]
    for axes, name in zip(grid, sets, strict=True):
        members = table[table["set"] == name]
        for number, (policy, (label, marker, colour)) in enumerate(POLICIES.items()):
            rows = members[members["policy"] == policy]
            rate, ends = percent(rows)
            positions = [predictors.index(row) + 0.25 * (number - 1) for row in rows["predictor"]]
            axes.errorbar(
                rate, positions, xerr=ends, fmt=marker, color=colour,
                markersize=4, capsize=2, label=label,
            )  # fmt: skip
        axes.set_title(f"{name}, n = {members['balls'].iloc[0]}")
        axes.set_xlabel("return rate (%)")
        axes.grid(visible=False, axis="y")
    label_rows(grid[0], [predictor_label(name) for name in predictors])
    add_legend(figure, grid[0], ncols=3)
    return figure


def readings_figure(rates: pd.DataFrame) -> Figure:
    """Draw return rates of predictors under both readings, a panel an observation and horizons.

    Args:
        rates: one row per ``observation``, ``horizons_ms``, ``predictor`` and ``protocol``, with
            ``balls``, ``trainings``, and ``return_rate`` with its interval.
    """
    predictors = sorted(rates["predictor"].unique(), key=predictor_order)
    panels = list(rates.groupby(["observation", "horizons_ms"], sort=False))
    figure = Figure(figsize=(FIGURE_WIDTH, 1.5 + 0.28 * len(predictors)))
    grid = figure.subplots(1, len(panels), sharex=True, sharey=True, squeeze=False)[0]
    for axes, ((observation, horizons), members) in zip(grid, panels, strict=True):
        for protocol, (marker, shift) in READINGS.items():
            rows = members[members["protocol"] == protocol].set_index("predictor").loc[predictors]
            rate, ends = percent(rows)
            for place, name in enumerate(predictors):
                axes.errorbar(
                    rate[name], place + shift, xerr=[[end[name]] for end in ends],
                    fmt=marker, color=predictor_colour(name), markersize=4, capsize=2,
                )  # fmt: skip
            axes.plot([], [], marker, color=INK, markersize=4, label=PROTOCOLS[protocol])
        axes.set_xlabel("returns (%)")
        axes.grid(visible=False, axis="y")
        axes.set_title(f"{OBSERVED[str(observation)]},\n{ahead(str(horizons))}")
    label_rows(grid[0], [predictor_label(name) for name in predictors])
    add_legend(figure, grid[0], ncols=2, title=f"{sample(rates)}, 95 % intervals")
    return figure


def mechanism_figure(gains: pd.DataFrame) -> Figure:
    """Draw by how much predictors return more than simulator C: time between forecasts by latency.

    A row of panels a predictor, a column an observation and error of labels, at the nearer
    horizons. Differences that are significant with all comparisons allowed for are bold. Frames
    mark the setting of sim2real, and the paper's physics, whose latency is not stated. The scale
    of colours ends at the multiple of 5 points above the largest difference.

    Args:
        gains: one row per ``observation``, ``horizons_ms``, ``label_error``, ``every_ms``,
            ``latency_ms``, ``predictor`` and ``outcome``, with ``difference`` and ``p_holm``.
    """
    nearest = gains["horizons_ms"].iloc[0]
    shown = gains[(gains["outcome"] == "returns") & (gains["horizons_ms"] == nearest)]
    predictors = sorted(shown["predictor"].unique(), key=predictor_order)
    columns = list(shown.groupby(["observation", "label_error"], sort=False))
    largest = STEP * max(1.0, np.ceil(100 * shown["difference"].abs().max() / STEP))
    figure = Figure(figsize=(FIGURE_WIDTH, 1.0 + 1.7 * len(predictors)))
    grid = figure.subplots(len(predictors), len(columns), sharex=True, sharey=True, squeeze=False)
    for row, name in zip(grid, predictors, strict=True):
        for axes, (_, cell) in zip(row, columns, strict=True):
            image = _draw_surface(axes, cell[cell["predictor"] == name], largest)
        row[0].set_ylabel(f"{predictor_label(name)}\nlatency (ms)")
    for axes, ((observation, error), _) in zip(grid[0], columns, strict=True):
        labels = f"label error {100 * error:.0f} %" if error else "correct labels"
        axes.set_title(f"{OBSERVED[observation]},\n{labels}", fontsize="medium")
    figure.supxlabel("time between forecasts (ms)", fontsize="medium")
    label = f"returns minus simulator C's (points), horizons {ahead(nearest)}"
    figure.colorbar(image, ax=grid, label=label)
    frames = [
        Patch(fill=False, linestyle="solid", label="sim2real"),
        Patch(fill=False, linestyle="dashed", label="the paper's physics (latency not stated)"),
    ]
    title = "bold: significant at 5 % after Holm's correction"
    figure.legend(handles=frames, loc="outside upper center", ncols=2, title=title)
    return figure


def _draw_surface(axes: Axes, cell: pd.DataFrame, largest: float) -> AxesImage:
    times, latencies = list(cell["every_ms"].unique()), list(cell["latency_ms"].unique())
    table = cell.pivot(index="latency_ms", columns="every_ms", values="difference")
    gain = 100 * table.loc[latencies, times].to_numpy()
    p_values = cell.pivot(index="latency_ms", columns="every_ms", values="p_holm")
    image = axes.imshow(
        gain, origin="lower", aspect="auto", cmap="RdBu", vmin=-largest, vmax=largest
    )
    for (y, x), value in np.ndenumerate(gain):
        weight = "bold" if p_values.loc[latencies[y], times[x]] < 0.05 else "normal"
        colour = "white" if abs(value) > DARK * largest else INK
        axes.text(
            x, y, f"{round(value):+d}", color=colour, weight=weight,
            ha="center", va="center", fontsize=7,
        )  # fmt: skip
    axes.set_xticks(range(len(times)), [time.replace(" ", "\n") for time in times], fontsize=7)
    axes.set_yticks(range(len(latencies)), list(map(str, latencies)), fontsize=7)
    axes.grid(visible=False)
    axes.add_patch(Rectangle((-0.5, -0.5), 1, 1, fill=False, linestyle="solid"))
    last = len(times) - 1.5
    axes.add_patch(Rectangle((last, -0.5), 1, len(latencies), fill=False, linestyle="dashed"))
    return image
