"""The report of `close_gap`: verdicts, their agreement between splits, errors and causes."""

from collections import Counter
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
import pandas as pd
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from rallygap.models.gap.verdict import Cause, Gap, Verdict
from rallygap.pipeline.gap.figures import (
    ROW_HEIGHT,
    add_legend,
    draw_departure,
    draw_errors,
    shade_undetectable,
)
from rallygap.pipeline.io.amended_simulators import case_name
from rallygap.pipeline.runtime.stage_run import StageRun
from rallygap.pipeline.web.figure_style import FIGURE_WIDTH
from rallygap.pipeline.web.labels import simulator_label
from rallygap.pipeline.web.numbers import number, with_unit
from rallygap.pipeline.web.report_items import ReportFigure, ReportItem, ReportTable

CASE = ["source", "simulator", "split"]
CAUSE = ["cause", "role", "kind", "unit", "nominal", "estimate", "low", "high"]
CAUSE += ["p_value", "gap_share"]
WORTH = ["worth_mm", "worth_low", "worth_high"]
CLOSED = ["removable_closed", "closed_low", "closed_high"]
REDUCTION = ["reduction_low_mm", "reduction_high_mm"]
LANDING = ["landing_before_mm", "landing_after_mm", "landing_floor_mm"]
ERRORS = [
    "horizon_ms",
    *("before_mm", "before_low", "before_high"),
    *("after_mm", "after_low", "after_high"),
    "floor_mm",
]
FIRST_MS, LAST_MS = 100, 300  # horizons of the error table
HEADROOM = 1.3  # inch, for titles, the axis and the legend
SPREAD = 0.5  # of the marks of a row, which are 1 apart


@dataclass(frozen=True)
class CaseVerdict:
    """The verdict on so many shots of a source, drawn in one split, and a simulator."""

    source: str
    simulator: str
    split: int
    shots: int
    verdict: Verdict


def items(run: StageRun) -> Iterator[ReportItem]:
    """Yield errors and leading causes of every source, then the tables."""
    verdicts = [_read(run, row) for row in run.kept("close_gap", "cases").to_dict("records")]
    for source in dict.fromkeys(case.source for case in verdicts):
        members = [case for case in verdicts if case.source == source]
        yield closing_figure(members)
        if any(detectable_causes(case.verdict) for case in members):
            yield stability_figure(members)
    settings = run.params.close_gap
    experiment = (
        f"At most {settings.shots} training shots of a source, drawn at random: two in three "
        f"for naming, the rest for verification; {settings.splits} splits."
    )
    yield ReportTable(
        verdict_table(verdicts),
        "verdicts",
        title="Verdicts on training shots",
        caption=f"{experiment} causes: leading ones and sensor faults, estimates with 95 % "
        "intervals; where the shots cannot separate a cause from others, these follow after "
        "`or`. minor: number of parameters that are minor structure. misfits: checks of the "
        "model that fail. unexplained: share of the gap. removable_closed: share of the "
        "difference between the nominal simulator's error and the floor that was closed on "
        "held-out shots, with its 95 % interval, bootstrap over shots. reduction: 95 % "
        "interval of the nominal error less the amended one, mean over horizons. landing: "
        "root mean square error of the predicted landing position.",
    )
    yield ReportTable(
        stability_table(verdicts),
        "stability",
        title="Agreement of verdicts between splits",
        caption=f"{experiment} found: number of splits with the leading cause; estimate: "
        "their mean, with the lowest and the highest.",
    )
    yield ReportTable(
        cause_table(verdicts),
        "causes",
        title="Causes of the gap",
        caption="cause: effect.parameter; estimate with its 95 % interval (low, high); "
        "p_value: probability that the largest of all hypotheses is as large without any gap; "
        "gap_share: share of the gap; worth: by how much held-out predictions err more "
        "without the cause alone, mean over horizons, with its 95 % interval; possible: "
        "parameters that these shots cannot separate, the cause first.",
    )
    yield ReportTable(
        error_table(verdicts),
        "errors",
        title="Prediction errors before and after",
        caption="Root mean square distance to measured positions on held-out shots, each "
        "predicted from its first twelve samples, with the nominal (before) and the amended "
        "(after) simulator. low and high: 95 %, bootstrap over shots. floor_mm: error of a "
        "correct simulator, with the estimated launch errors, bounce scatter and sensor noise.",
    )


def _read(run: StageRun, row: dict[Any, Any]) -> CaseVerdict:
    name = case_name(row["source"], row["simulator"], row["split"])
    text = run.input("close_gap", f"{name}.json").read_text(encoding="utf-8")
    return CaseVerdict(**row, verdict=Verdict.from_json(text))


def closing_figure(verdicts: Sequence[CaseVerdict]) -> ReportFigure:
    """Draw the errors on one source, a panel per simulator and a line per split."""
    source, simulators = verdicts[0].source, _simulators(verdicts)
    figure = Figure(figsize=(FIGURE_WIDTH, 3.6))
    panels = figure.subplots(1, len(simulators), sharey=True, squeeze=False)[0]
    for axes, simulator in zip(panels, simulators, strict=True):
        for case in verdicts:
            if case.simulator == simulator and case.verdict.gap:
                draw_errors(axes, case.verdict.gap)
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


def stability_figure(verdicts: Sequence[CaseVerdict]) -> ReportFigure:
    """Draw the detectable causes on one source, a panel per simulator and a mark per split."""
    source, simulators = verdicts[0].source, _simulators(verdicts)
    names = list(
        dict.fromkeys(c.identity for case in verdicts for c in detectable_causes(case.verdict))
    )
    figure = Figure(figsize=(FIGURE_WIDTH, HEADROOM + ROW_HEIGHT * len(names) / 1.6))
    panels = figure.subplots(1, len(simulators), sharex=True, sharey=True, squeeze=False)[0]
    for axes, simulator in zip(panels, simulators, strict=True):
        _draw_causes(axes, [case for case in verdicts if case.simulator == simulator], names)
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


def _draw_causes(axes: Axes, verdicts: Sequence[CaseVerdict], names: Sequence[str]) -> None:
    shade_undetectable(axes)
    for place, case in enumerate(verdicts):
        offset = SPREAD * ((place + 0.5) / len(verdicts) - 0.5)
        for cause in detectable_causes(case.verdict):
            row = names.index(cause.identity) + offset
            draw_departure(axes, row, cause, case.verdict, line=2, mark=4)
    axes.set_xscale("symlog", linthresh=1.0, linscale=0.3)
    axes.xaxis.set_major_formatter("{x:g}")
    axes.grid(axis="y", visible=False)


def _simulators(verdicts: Sequence[CaseVerdict]) -> list[str]:
    return list(dict.fromkeys(case.simulator for case in verdicts))


def verdict_table(verdicts: Sequence[CaseVerdict]) -> pd.DataFrame:
    """Return one row per case: the verdict, with its causes in text."""
    return pd.DataFrame([{**_case(case), **_verdict(case)} for case in verdicts])


def cause_table(verdicts: Sequence[CaseVerdict]) -> pd.DataFrame:
    """Return one row per case and cause."""
    rows = [{**_case(case), **_cause(cause)} for case in verdicts for cause in case.verdict.causes]
    return pd.DataFrame(rows, columns=[*CASE, *CAUSE, *WORTH, "possible"])


def error_table(verdicts: Sequence[CaseVerdict]) -> pd.DataFrame:
    """Return one row per case and horizon: errors on held-out shots."""
    rows = [
        {**_case(case), **row}
        for case in verdicts
        if case.verdict.gap
        for row in _errors(case.verdict.gap)
        if FIRST_MS <= row["horizon_ms"] <= LAST_MS
    ]
    return pd.DataFrame(rows, columns=[*CASE, *ERRORS])


def stability_table(verdicts: Sequence[CaseVerdict]) -> pd.DataFrame:
    """Return one row per source, simulator and leading cause: its splits and estimates.

    ``verdicts`` counts the splits' verdicts; a source and simulator without any has one row.
    """
    causes = cause_table(verdicts).query("role == 'leading'")
    rows = []
    for setting, cases in verdict_table(verdicts).groupby(CASE[:2], sort=False):
        counts = Counter(cases["verdict"])
        row = {
            **dict(zip(CASE, setting, strict=False)),
            "verdicts": ", ".join(f"{count} {word}" for word, count in counts.items()),
            "splits": len(cases),
        }
        members = causes[(causes[CASE[:2]] == setting).all(axis=1)]
        rows += [{**row, **cause} for cause in _over_splits(members)] or [row]
    columns = ["verdicts", "cause", "unit", "found", "splits", "estimate", "lowest", "highest"]
    return pd.DataFrame(rows, columns=[*CASE[:2], *columns])


def _over_splits(causes: pd.DataFrame) -> list[dict[str, Any]]:
    return [
        {
            "cause": cause,
            "unit": unit,
            "found": len(splits),
            "estimate": splits["estimate"].mean(),
            "lowest": splits["estimate"].min(),
            "highest": splits["estimate"].max(),
        }
        for (cause, unit), splits in causes.groupby(["cause", "unit"], sort=False)
    ]


def _errors(gap: Gap) -> list[dict[str, float]]:
    before, after = (
        zip(*gap.before_interval_mm, strict=True),
        zip(*gap.after_interval_mm, strict=True),
    )
    columns = (gap.horizons_ms, gap.before_mm, *before, gap.after_mm, *after, gap.floor_mm)
    return [dict(zip(ERRORS, row, strict=True)) for row in zip(*columns, strict=True)]


def _case(case: CaseVerdict) -> dict[str, Any]:
    values = (case.source, case.simulator, case.split)
    return dict(zip(CASE, values, strict=True))


def _verdict(case: CaseVerdict) -> dict[str, Any]:
    verdict, gap = case.verdict, case.verdict.gap
    closed = landing = (np.nan, np.nan, np.nan)
    reduction = (np.nan, np.nan)
    if gap and gap.removable_closed is not None and gap.removable_closed_interval:
        closed = (gap.removable_closed, *gap.removable_closed_interval)
    if gap and gap.reduction_mm:
        reduction = gap.reduction_mm
    if gap and gap.landing:
        landing = (gap.landing.before_mm, gap.landing.after_mm, gap.landing.floor_mm)
    return {
        "shots": case.shots,
        "verdict": verdict.verdict,
        "causes": "; ".join(_text(cause) for cause in verdict.main_causes) or None,
        "minor": len(verdict.causes) - len(verdict.main_causes),
        "misfits": ", ".join(check.name for check in verdict.misfits) or None,
        "unexplained": verdict.unexplained.share,
        **dict(zip(CLOSED, closed, strict=True)),
        **dict(zip(REDUCTION, reduction, strict=True)),
        **dict(zip(LANDING, landing, strict=True)),
    }


def _text(cause: Cause) -> str:
    others = f" or {', '.join(cause.alternatives)}" if cause.alternatives else ""
    estimate, (low, high) = with_unit(cause.estimate, cause.unit), cause.interval
    return f"{cause.identity}{others} {estimate} ({number(low)} to {number(high)})"


def _cause(cause: Cause) -> dict[str, Any]:
    low, high = cause.interval
    worth = (cause.worth.mm, *cause.worth.interval) if cause.worth else (np.nan,) * 3
    return {
        "cause": cause.identity,
        "low": low,
        "high": high,
        **dict(zip(WORTH, worth, strict=True)),
        "possible": ", ".join(cause.possible),
        **{name: getattr(cause, name) for name in CAUSE if hasattr(cause, name)},
    }
