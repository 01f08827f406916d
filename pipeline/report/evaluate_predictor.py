"""The report of `evaluate_predictor`: forecast errors, and coverage of prediction regions."""

from collections.abc import Iterator, Sequence
from typing import Any

import pandas as pd
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.patches import Patch

from rallygap.models.predictors.evaluation import MEASURED, SHOWN_HORIZONS_MS
from rallygap.pipeline.io.source_manifest import SourceRecord, read_manifest
from rallygap.pipeline.report.plots import draw_band
from rallygap.pipeline.runtime.stage_run import StageRun
from rallygap.pipeline.web.figure_style import (
    FIGURE_WIDTH,
    MUTED,
    predictor_colour,
    predictor_order,
)
from rallygap.pipeline.web.labels import predictor_label
from rallygap.pipeline.web.report_items import ReportFigure, ReportItem, ReportTable

VARIANTS = ("_with_net", "_without_net")  # of predictors, in the tables only
QUANTITIES = {
    "position": "position error (mm)",
    "velocity": "velocity error (m/s)",
    "spin": "spin error (rad/s)",
}
# Rows of panels: title to windows and statistic. Means share one scale.
ROWS = {
    "mean, all windows": ("all", "mean"),
    "standard deviation, all windows": ("all", "std"),
    "mean, with a bounce": ("with", "mean"),
    "mean, without a bounce": ("without", "mean"),
}
HEADROOM = 0.15  # share of the panel above the lines, for the number of windows
FINE_TUNED = "_fine_tuned"  # at the end of predictors' names
# More bands of errors than these, and more lines of coverage than these and fine-tuned ones, would
# hide one another; the tables have all predictors.
WITH_BANDS = ("physics_c", "hybrid", "transformer", "amended_imperfect_c")
WITH_COVERAGE = (*WITH_BANDS, "oracle")
EVERY_MS = 25  # of the figure of coverage


def items(run: StageRun) -> Iterator[ReportItem]:
    """Yield figures of every set, then the tables, then coverage."""
    sources = read_manifest(run.input("ingest", "manifest.json")).sources
    errors = run.kept("evaluate_predictor", "errors")
    for name in errors["set"].unique():
        yield from _error_figures(sources[name], errors[errors["set"] == name])
    yield ReportTable(
        errors[errors["horizon_ms"].isin(SHOWN_HORIZONS_MS)],
        "forecast_error",
        title="Forecast error at 100, 200 and 300 ms",
        caption="Mean with its 95 % interval bootstrapped over recordings, median and standard "
        "deviation over windows. Position in mm, velocity in m/s, spin in rad/s; n windows. "
        "Simulated balls also against the true state, on the same windows.",
    )
    yield ReportTable(
        run.kept("evaluate_predictor", "differences"),
        "forecast_error_difference",
        title="Predictors with training data compared with the others",
        caption="Error of the predictor minus that of the other on the same windows, with its 95 % "
        "interval bootstrapped over recordings: negative where the predictor is better. "
        "lower_share: share of all horizons from 100 to 300 ms at which its mean error is "
        "lower. Position in mm, velocity in m/s, spin in rad/s; n windows.",
    )
    yield ReportTable(
        run.kept("evaluate_predictor", "groups"),
        "forecast_error_by_group",
        title="Position error at 300 ms, by group of recordings",
        caption="Mean in mm with its 95 % interval bootstrapped over recordings; n windows.",
    )
    yield ReportTable(
        run.kept("evaluate_predictor", "net"),
        "forecast_error_by_net",
        title="Position error at 300 ms, with and without net contact",
        caption="Mean in mm with its 95 % interval bootstrapped over recordings; n windows. with: "
        "the ball truly meets the net within the 300 ms, which is known for the arena only.",
    )
    yield ReportTable(
        run.kept("evaluate_predictor", "predictors"),
        "predictors",
        title="Predictors",
        caption="The simulator or the number of trained parameters of each predictor, and its "
        "training data. Amended simulators forecast balls of the source that amended them. The "
        "oracle knows the hidden physics of the arena, not the systematic errors of its cameras.",
    )
    coverage = run.kept("evaluate_predictor", "coverage")
    yield ReportTable(
        coverage[coverage["horizon_ms"].isin(SHOWN_HORIZONS_MS)],
        "coverage",
        title="Prediction regions at 100, 200 and 300 ms",
        caption="Share of measured positions inside the prediction regions of 50 and 90 %, with "
        "its 95 % interval bootstrapped over recordings; the size of the regions in mm, the mean "
        "radius of balls of the same volume; and the continuous ranked probability score in mm, "
        "mean over the axes. The predictor gives the shape of a region; its radius is from the "
        "errors on validation windows, at every horizon on its own.",
    )
    for name in coverage["set"].unique():
        yield ReportFigure(
            coverage_figure(coverage[coverage["set"] == name]),
            f"coverage_{name}",
            title=f"Coverage and size of prediction regions on {name}",
            caption="Share of measured positions inside the prediction regions of 50 and 90 % "
            "(dotted line), and their mean radius. The table has intervals.",
        )


def _error_figures(source: SourceRecord, errors: pd.DataFrame) -> Iterator[ReportFigure]:
    """Yield the error over the horizon, against measurement and truth."""
    for against, rows in errors.groupby("against", sort=False):
        label = source.name if against == MEASURED else f"{source.name}_{against}"
        state = "measured" if against == MEASURED else "true"
        drawn = rows[~rows["predictor"].str.endswith(VARIANTS)]
        caption = (
            f"Distance between forecast and {state} state over the horizon: mean over the test "
            "windows (line) with its 95 % interval bootstrapped over recordings (band), and "
            "standard deviation. A window counts as with a bounce if the ball meets the table "
            f"within 300 ms. {source.note}"
        )
        if source.spin == "per_recording":
            caption += (
                " A shot has one spin label, valid until the first contact or the end of the "
                "tracked arc: the spin error contains only forecasts before a contact."
            )
        yield ReportFigure(
            forecast_error_figure(drawn.assign(set=label)),
            f"forecast_error_{label}",
            title=f"Forecast error on {source.name}, against the {state} state",
            caption=caption,
        )


def forecast_error_figure(frame: pd.DataFrame) -> Figure:
    """Draw the error of every predictor on one set: columns are quantities, rows kinds of window.

    A panel shows each predictor's mean error with its bootstrap interval, or its standard
    deviation. Quantities and kinds of window without data are left out.

    Args:
        frame: one row for each predictor, quantity and horizon of one set, with columns set,
            predictor, quantity ("position" mm, "velocity" m/s, "spin" rad/s), horizon_ms,
            bounce ("all", "with", "without"), mean, std, n, ci_low, ci_high.
    """
    quantities = [name for name in QUANTITIES if name in set(frame["quantity"])]
    titles = [title for title, (window, _) in ROWS.items() if window in set(frame["bounce"])]
    predictors = sorted(frame["predictor"].unique(), key=predictor_order)
    figure = Figure(figsize=(FIGURE_WIDTH, 1.4 + 1.8 * len(titles)))
    grid = figure.subplots(len(titles), len(quantities), sharex=True, squeeze=False)
    for panels, title in zip(grid, titles, strict=True):
        window, statistic = ROWS[title]
        for axes, top, quantity in zip(panels, grid[0], quantities, strict=True):
            if statistic == "mean" and axes is not top:
                axes.sharey(top)
            rows = frame[(frame["quantity"] == quantity) & (frame["bounce"] == window)]
            _draw_errors(axes, rows, statistic, predictors)
            axes.set_ylabel(QUANTITIES[quantity])
        panels[0].set_title(title)
    for axes in grid.flat:
        axes.margins(y=HEADROOM)
        axes.set_ylim(bottom=0)
    for axes in grid[-1]:
        axes.set_xlabel("forecast horizon (ms)")
        axes.set_xlim(100, 300)
        axes.set_xticks([100, 150, 200, 250, 300])
    _add_legend(
        figure,
        predictors,
        title=f"{frame['set'].iloc[0]}: forecast error",
        title_fontproperties={"size": 12, "weight": "bold"},
        alignment="left",
    )
    label = "95 % bootstrap interval of the mean; all intervals are in the tables"
    interval = Patch(color=MUTED, alpha=0.35, lw=0, label=label)
    figure.legend(handles=[interval], loc="outside lower center")
    return figure


def _draw_errors(axes: Axes, rows: pd.DataFrame, statistic: str, predictors: list[str]) -> None:
    for predictor in predictors:
        line = rows[rows["predictor"] == predictor].sort_values("horizon_ms")
        style = _line_style(predictor)
        if statistic == "mean" and predictor in WITH_BANDS:
            draw_band(axes, line["horizon_ms"], line, style["color"], alpha=0.22)
        axes.plot(line["horizon_ms"], line[statistic], **style)
    counts = sorted({rows["n"].min(), rows["n"].max()}) if len(rows) else [0]
    count = "n = " + " to ".join(f"{number:,}" for number in counts)
    note = axes.text(0.04, 0.97, count, transform=axes.transAxes, va="top", color=MUTED, fontsize=8)
    note.set_bbox({"color": "white", "pad": 1})


def coverage_figure(rows: pd.DataFrame) -> Figure:
    """Draw a column of panels for each level: coverage above, size below, every 25 ms.

    Args:
        rows: of one set, with columns predictor, level, horizon_ms, coverage, size_mm. Of the
            predictors, ``WITH_COVERAGE`` are drawn, also fine-tuned, or all if the set has none.
    """
    rows = rows[rows["horizon_ms"] % EVERY_MS == 0]
    levels = sorted(rows["level"].unique())
    every = sorted(rows["predictor"].unique(), key=predictor_order)
    main = [name for name in every if name.removesuffix(FINE_TUNED) in WITH_COVERAGE]
    figure = Figure(figsize=(FIGURE_WIDTH, 5.5))
    grid = figure.subplots(2, len(levels), sharex=True, squeeze=False)
    for (above, below), level in zip(grid.T, levels, strict=True):
        for name in main or every:
            line = rows[(rows["predictor"] == name) & (rows["level"] == level)]
            above.plot(line["horizon_ms"], 100 * line["coverage"], **_line_style(name))
            below.plot(line["horizon_ms"], line["size_mm"], **_line_style(name))
        above.axhline(100 * level, color=MUTED, linestyle="dotted")
        above.set_title(f"regions of {100 * level:.0f} %")
        below.set_xlabel("forecast horizon (ms)")
        below.set_ylim(bottom=0)
    grid[0, 0].set_ylabel("coverage (%)")
    grid[1, 0].set_ylabel("radius (mm)")
    _add_legend(figure, main or every)
    return figure


def _line_style(predictor: str) -> dict[str, Any]:
    """Return colour and dashes: fine-tuned is dashed, in its network's colour; amended dotted."""
    network = predictor.removesuffix(FINE_TUNED)
    dashes = "dotted" if predictor.startswith("amended_") else "solid"
    return {
        "color": predictor_colour(network),
        "linestyle": dashes if network == predictor else "dashed",
    }


def _add_legend(figure: Figure, predictors: Sequence[str], **style: Any) -> None:
    lines = [
        Line2D([], [], **_line_style(name), label=predictor_label(name)) for name in predictors
    ]
    figure.legend(handles=lines, loc="outside upper left", ncols=min(len(lines), 3), **style)
