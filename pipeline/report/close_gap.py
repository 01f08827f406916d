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
from rallygap.pipeline.report.plots import label_rows
from rallygap.pipeline.runtime.stage_run import StageRun
from rallygap.pipeline.web.figure_style import FIGURE_WIDTH
from rallygap.pipeline.web.labels import simulator_label
from rallygap.pipeline.web.numbers import number, with_unit
from rallygap.pipeline.web.report_items import ReportFigure, ReportItem, ReportTable

CASE = ["source", "simulator", "split"]
CAUSE = ["cause", "role", "kind", "unit", "nominal", "estimate", "low", "high"]
CAUSE += ["p_value", "gap_share", "worth_mm", "worth_low", "worth_high", "possible"]
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
    verdicts = []
    for source, simulator, split, shots in run.kept("close_gap", "cases").to_numpy():
        file = run.input("close_gap", f"{case_name(source, simulator, split)}.json")
        verdict = Verdict.from_json(file.read_text(encoding="utf-8"))
        verdicts.append(CaseVerdict(source, simulator, split, shots, verdict))
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


def closing_figure(verdicts: Sequence[CaseVerdict]) -> ReportFigure:
    """Draw the errors on one source, a panel per simulator and a line per split."""
    figure, panels = _panels(verdicts, 3.6)
    for axes, members in panels:
        for case in members:
            if case.verdict.gap:
                draw_errors(axes, case.verdict.gap)
        axes.set_xlabel("prediction horizon (ms)")
    panels[0][0].set_ylim(bottom=0)
    panels[0][0].set_ylabel("position error (mm)")
    add_legend(figure)
    source = verdicts[0].source
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
    causes = [cause for case in verdicts for cause in detectable_causes(case.verdict)]
    names = list(dict.fromkeys(cause.identity for cause in causes))
    figure, panels = _panels(verdicts, HEADROOM + ROW_HEIGHT * len(names) / 1.6, sharex=True)
    for axes, members in panels:
        shade_undetectable(axes)
        for place, case in enumerate(members):
            offset = SPREAD * ((place + 0.5) / len(members) - 0.5)
            for cause in detectable_causes(case.verdict):
                row = names.index(cause.identity) + offset
                draw_departure(axes, row, cause, case.verdict, line=2, mark=4)
        axes.set_xscale("symlog", linthresh=1.0, linscale=0.3)
        axes.xaxis.set_major_formatter("{x:g}")
        axes.grid(axis="y", visible=False)
    figure.supxlabel("estimate − simulator (min. detectable effects)", fontsize="medium")
    label_rows(panels[0][0], names)
    add_legend(figure)
    source = verdicts[0].source
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


def _panels(
    verdicts: Sequence[CaseVerdict], height: float, *, sharex: bool = False
) -> tuple[Figure, list[tuple[Axes, list[CaseVerdict]]]]:
    """Return a figure, and a panel for each simulator with the verdicts on it."""
    by_simulator: dict[str, list[CaseVerdict]] = {}
    for case in verdicts:
        by_simulator.setdefault(case.simulator, []).append(case)
    figure = Figure(figsize=(FIGURE_WIDTH, height))
    grid = figure.subplots(1, len(by_simulator), sharex=sharex, sharey=True, squeeze=False)[0]
    for axes, simulator in zip(grid, by_simulator, strict=True):
        axes.set_title(simulator_label(simulator))
    return figure, list(zip(grid, by_simulator.values(), strict=True))


def verdict_table(verdicts: Sequence[CaseVerdict]) -> pd.DataFrame:
    """Return one row per case: the verdict, with its causes in text."""
    return pd.DataFrame([_case(case) | _verdict(case.shots, case.verdict) for case in verdicts])


def cause_table(verdicts: Sequence[CaseVerdict]) -> pd.DataFrame:
    """Return one row per case and cause."""
    rows = [_case(case) | _cause(cause) for case in verdicts for cause in case.verdict.causes]
    return pd.DataFrame(rows, columns=[*CASE, *CAUSE])


def error_table(verdicts: Sequence[CaseVerdict]) -> pd.DataFrame:
    """Return one row per case and horizon: errors on held-out shots."""
    rows = [
        _case(case) | row
        for case in verdicts
        if case.verdict.gap
        for row in _errors(case.verdict.gap)
    ]
    return pd.DataFrame(rows, columns=[*CASE, *ERRORS])


def stability_table(verdicts: Sequence[CaseVerdict]) -> pd.DataFrame:
    """Return one row per source, simulator and leading cause: its splits and estimates.

    ``verdicts`` counts the splits' verdicts; a source and simulator without any has one row.
    """
    causes = cause_table(verdicts).query("role == 'leading'")
    estimates = causes.groupby([*CASE[:2], "cause", "unit"], sort=False)["estimate"]
    summary = estimates.agg(["size", "mean", "min", "max"]).reset_index()
    summary.columns = [*summary.columns[:4], "found", "estimate", "lowest", "highest"]
    cases = verdict_table(verdicts).groupby(CASE[:2], sort=False)["verdict"]
    counted = cases.agg(verdicts=_counted, splits="size").reset_index()
    columns = ["verdicts", "cause", "unit", "found", "splits", "estimate", "lowest", "highest"]
    return counted.merge(summary, "left", on=CASE[:2])[[*CASE[:2], *columns]]


def _counted(words: pd.Series) -> str:
    return ", ".join(f"{count} {word}" for word, count in Counter(words).items())


def _case(case: CaseVerdict) -> dict[str, Any]:
    return {"source": case.source, "simulator": case.simulator, "split": case.split}


def _errors(gap: Gap) -> Iterator[dict[str, float]]:
    """Yield the errors at the horizons of the table."""
    intervals = zip(gap.before_interval_mm, gap.after_interval_mm, strict=True)
    errors = zip(gap.horizons_ms, gap.before_mm, gap.after_mm, gap.floor_mm, strict=True)
    for (horizon, before, after, floor), ends in zip(errors, intervals, strict=True):
        if FIRST_MS <= horizon <= LAST_MS:
            row = (horizon, before, *ends[0], after, *ends[1], floor)
            yield dict(zip(ERRORS, row, strict=True))


def _verdict(shots: int, verdict: Verdict) -> dict[str, Any]:
    gap, landing = verdict.gap, verdict.gap.landing if verdict.gap else None
    closed: Sequence[float] = (np.nan,) * 3
    if gap and gap.removable_closed is not None and gap.removable_closed_interval:
        closed = (gap.removable_closed, *gap.removable_closed_interval)
    reduction = gap.reduction_mm if gap and gap.reduction_mm else (np.nan, np.nan)
    return {
        "shots": shots,
        "verdict": verdict.verdict,
        "causes": "; ".join(_text(cause) for cause in verdict.main_causes) or None,
        "minor": len(verdict.causes) - len(verdict.main_causes),
        "misfits": ", ".join(check.name for check in verdict.misfits) or None,
        "unexplained": verdict.unexplained.share,
        **dict(zip(("removable_closed", "closed_low", "closed_high"), closed, strict=True)),
        **dict(zip(("reduction_low_mm", "reduction_high_mm"), reduction, strict=True)),
        "landing_before_mm": landing.before_mm if landing else np.nan,
        "landing_after_mm": landing.after_mm if landing else np.nan,
        "landing_floor_mm": landing.floor_mm if landing else np.nan,
    }


def _text(cause: Cause) -> str:
    others = f" or {', '.join(cause.alternatives)}" if cause.alternatives else ""
    estimate, (low, high) = with_unit(cause.estimate, cause.unit), cause.interval
    return f"{cause.identity}{others} {estimate} ({number(low)} to {number(high)})"


def _cause(cause: Cause) -> dict[str, Any]:
    worth = (cause.worth.mm, *cause.worth.interval) if cause.worth else (np.nan,) * 3
    return {
        **{name: getattr(cause, name, None) for name in CAUSE},
        "cause": cause.identity,
        **dict(zip(("low", "high"), cause.interval, strict=True)),
        **dict(zip(("worth_mm", "worth_low", "worth_high"), worth, strict=True)),
        "possible": ", ".join(cause.possible),
    }
