"""Figures of the study."""

from collections.abc import Iterator

import numpy as np
import pandas as pd
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.image import AxesImage
from matplotlib.patches import Patch, Rectangle

from rallygap.pipeline.report.sample import sample
from rallygap.pipeline.runtime.stage_run import StageRun
from rallygap.pipeline.transfer.returns import PROTOCOLS
from rallygap.pipeline.web.figure_style import FIGURE_WIDTH, INK, predictor_colour, predictor_order
from rallygap.pipeline.web.labels import predictor_label
from rallygap.pipeline.web.report_items import ReportFigure, ReportItem

MARKERS = {"first_window": "o", "every_tick": "s"}
APART = 0.16  # of the two readings of a predictor
ROW, HEADROOM = 0.28, 1.5  # inch a predictor, and for titles and axes
STEP = 5  # points; the colour scale ends at a multiple
DARK = 0.6  # share of the scale beyond which text is white
POLICY = ["observation", "horizons_ms"]
OBSERVED = {"intercept": "intercept features", "strict": "the paper's inputs"}


def items(run: StageRun) -> Iterator[ReportItem]:
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


def readings_figure(rates: pd.DataFrame) -> Figure:
    """Draw return rates of predictors under both readings, a panel an observation and horizons.

    Args:
        rates: one row per ``observation``, ``horizons_ms``, ``predictor`` and ``protocol``, with
            ``balls``, ``trainings``, and ``return_rate`` with its interval.
    """
    predictors = sorted(rates["predictor"].unique(), key=predictor_order)
    panels = [
        ((str(observation), str(horizons)), rows)
        for (observation, horizons), rows in rates.groupby(POLICY, sort=False)
    ]
    figure = Figure(figsize=(FIGURE_WIDTH, HEADROOM + ROW * len(predictors)))
    grid = figure.subplots(1, len(panels), sharex=True, sharey=True, squeeze=False)[0]
    for axes, ((observation, horizons), rows) in zip(grid, panels, strict=True):
        _draw_readings(axes, rows, predictors)
        axes.set_title(f"{OBSERVED[observation]},\n{horizons.replace('-', '–')} ms")
    grid[0].set_yticks(range(len(predictors)), [predictor_label(one) for one in predictors])
    grid[0].set_ylim(len(predictors) - 0.5, -0.5)
    handles, labels = grid[0].get_legend_handles_labels()
    title = f"{sample(rates)}, 95 % intervals"
    figure.legend(handles, labels, loc="outside lower center", ncols=2, title=title)
    return figure


def _draw_readings(axes: Axes, rows: pd.DataFrame, predictors: list[str]) -> None:
    for protocol, label in PROTOCOLS.items():
        some = rows[rows["protocol"] == protocol].set_index("predictor").loc[predictors]
        rate = 100 * some["return_rate"]
        ends = [rate - 100 * some["return_rate_low"], 100 * some["return_rate_high"] - rate]
        apart = APART if protocol == "every_tick" else -APART
        for place, name in enumerate(predictors):
            axes.errorbar(
                rate[name], place + apart, xerr=[[end[name]] for end in ends],
                fmt=MARKERS[protocol], color=predictor_colour(name), markersize=4, capsize=2,
            )  # fmt: skip
        axes.plot([], [], MARKERS[protocol], color=INK, markersize=4, label=label)
    axes.set_xlabel("returns (%)")
    axes.grid(visible=False, axis="y")


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
    label = f"returns minus simulator C's (points), horizons {nearest.replace('-', '–')} ms"
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
    known = cell.pivot(index="latency_ms", columns="every_ms", values="p_holm")
    image = axes.imshow(
        gain, origin="lower", aspect="auto", cmap="RdBu", vmin=-largest, vmax=largest
    )
    for (y, x), value in np.ndenumerate(gain):
        sure = known.loc[latencies[y], times[x]] < 0.05
        weight = "bold" if sure else "normal"
        colour = "white" if abs(value) > DARK * largest else INK
        axes.text(
            x, y, f"{round(value):+d}", color=colour, weight=weight,
            ha="center", va="center", fontsize=7,
        )  # fmt: skip
    axes.set_xticks(range(len(times)), [one.replace(" ", "\n") for one in times], fontsize=7)
    axes.set_yticks(range(len(latencies)), [str(one) for one in latencies], fontsize=7)
    axes.grid(visible=False)
    axes.add_patch(Rectangle((-0.5, -0.5), 1, 1, fill=False, linestyle="solid"))
    last = len(times) - 1.5
    axes.add_patch(Rectangle((last, -0.5), 1, len(latencies), fill=False, linestyle="dashed"))
    return image
