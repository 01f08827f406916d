"""The report of `evaluate_predictor`: forecast errors, and coverage of prediction regions."""

from collections.abc import Iterator

import pandas as pd

from rallygap.models.predictors.evaluation import SHOWN_HORIZONS_MS
from rallygap.pipeline.evaluation.forecasts import MEASURED
from rallygap.pipeline.io.source_manifest import SourceRecord, read_manifest
from rallygap.pipeline.report.coverage import coverage_figure
from rallygap.pipeline.report.forecast_error import forecast_error_figure
from rallygap.pipeline.runtime.stage_run import StageRun
from rallygap.pipeline.web.report_items import ReportFigure, ReportItem, ReportTable

VARIANTS = ("_with_net", "_without_net")  # of predictors, in the tables only


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
        yield ReportFigure(
            forecast_error_figure(drawn.assign(set=label)),
            f"forecast_error_{label}",
            title=f"Forecast error on {source.name}, against the {state} state",
            caption=_caption(source, state),
        )


def _caption(source: SourceRecord, state: str) -> str:
    caption = (
        f"Distance between forecast and {state} state over the horizon: mean over the test windows "
        "(line) with its 95 % interval bootstrapped over recordings (band), and standard "
        "deviation. A window counts as with a bounce if the ball meets the table within 300 ms. "
        f"{source.note}"
    )
    if source.spin == "per_recording":
        caption += (
            " A shot has one spin label, valid until the first contact or the end of the tracked "
            "arc: the spin error contains only forecasts before a contact."
        )
    return caption
