"""Tables and metrics of many verdicts."""

from collections import Counter
from collections.abc import Sequence
from typing import Any

import numpy as np
import pandas as pd

from rallygap.models.gap.verdict import Cause, Gap
from rallygap.pipeline.gap.cases import Diagnosed
from rallygap.pipeline.gap.wording import interval_text
from rallygap.pipeline.io.metrics import place, rounded
from rallygap.pipeline.io.numbers import with_unit
from rallygap.pipeline.io.report_items import ReportTable
from rallygap.pipeline.params import CloseGapSettings

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


def report_tables(diagnosed: Sequence[Diagnosed], settings: CloseGapSettings) -> list[ReportTable]:
    """Return the report's tables: verdicts, their stability, causes and errors."""
    experiment = (
        f"At most {settings.shots} training shots of a source, drawn at random: two in three "
        f"for naming, the rest for verification; {settings.splits} splits."
    )
    return [
        ReportTable(
            verdict_table(diagnosed),
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
        ),
        ReportTable(
            stability_table(diagnosed),
            "stability",
            title="Agreement of verdicts between splits",
            caption=f"{experiment} found: number of splits with the leading cause; estimate: "
            "their mean, with the lowest and the highest.",
        ),
        ReportTable(
            cause_table(diagnosed),
            "causes",
            title="Causes of the gap",
            caption="cause: effect.parameter; estimate with its 95 % interval (low, high); "
            "p_value: probability that the largest of all hypotheses is as large without any gap; "
            "gap_share: share of the gap; worth: by how much held-out predictions err more "
            "without the cause alone, mean over horizons, with its 95 % interval; possible: "
            "parameters that these shots cannot separate, the cause first.",
        ),
        ReportTable(
            error_table(diagnosed),
            "errors",
            title="Prediction errors before and after",
            caption="Root mean square distance to measured positions on held-out shots, each "
            "predicted from its first twelve samples, with the nominal (before) and the amended "
            "(after) simulator. low and high: 95 %, bootstrap over shots. floor_mm: error of a "
            "correct simulator, with the estimated launch errors, bounce scatter and sensor noise.",
        ),
    ]


def metrics(diagnosed: Sequence[Diagnosed]) -> dict[str, Any]:
    """Return ``{source: {simulator: {split: {verdict, minor, removable_closed, causes}}}}``.

    Causes are the leading ones and sensor faults.
    """
    found: dict[str, Any] = {}
    for row in verdict_table(diagnosed).to_dict("records"):
        content = {key: row[key] for key in ("verdict", "minor")}
        content["unexplained"] = rounded(row["unexplained"])
        if not np.isnan(row["removable_closed"]):  # where there is a gap to close
            content["removable_closed"] = rounded(row["removable_closed"])
        place(found, [row[key] for key in CASE]).update(content, causes={})
    for row in cause_table(diagnosed).query("role != 'minor'").to_dict("records"):
        names = ["estimate", "low", "high", *WORTH]
        numbers = {name: rounded(row[name]) for name in names if not np.isnan(row[name])}
        place(found, [*(row[key] for key in CASE), "causes"])[row["cause"]] = numbers
    return found


def verdict_table(diagnosed: Sequence[Diagnosed]) -> pd.DataFrame:
    """Return one row per case: the verdict, with its causes in text."""
    return pd.DataFrame([{**_case(diagnosis), **_verdict(diagnosis)} for diagnosis in diagnosed])


def cause_table(diagnosed: Sequence[Diagnosed]) -> pd.DataFrame:
    """Return one row per case and cause."""
    rows = [
        {**_case(diagnosis), **_cause(cause)}
        for diagnosis in diagnosed
        for cause in diagnosis.verdict.causes
    ]
    return pd.DataFrame(rows, columns=[*CASE, *CAUSE, *WORTH, "possible"])


def error_table(diagnosed: Sequence[Diagnosed]) -> pd.DataFrame:
    """Return one row per case and horizon: errors on held-out shots."""
    rows = [
        {**_case(diagnosis), **row}
        for diagnosis in diagnosed
        if diagnosis.verdict.gap
        for row in _errors(diagnosis.verdict.gap)
        if FIRST_MS <= row["horizon_ms"] <= LAST_MS
    ]
    return pd.DataFrame(rows, columns=[*CASE, *ERRORS])


def stability_table(diagnosed: Sequence[Diagnosed]) -> pd.DataFrame:
    """Return one row per source, simulator and leading cause: its splits and estimates.

    ``verdicts`` counts the splits' verdicts; a source and simulator without any has one row.
    """
    causes = cause_table(diagnosed).query("role == 'leading'")
    rows = []
    for setting, cases in verdict_table(diagnosed).groupby(CASE[:2], sort=False):
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


def _case(diagnosis: Diagnosed) -> dict[str, Any]:
    values = (diagnosis.case.source, diagnosis.case.simulator_name, diagnosis.case.split)
    return dict(zip(CASE, values, strict=True))


def _verdict(diagnosis: Diagnosed) -> dict[str, Any]:
    verdict, gap = diagnosis.verdict, diagnosis.verdict.gap
    closed = landing = (np.nan, np.nan, np.nan)
    reduction = (np.nan, np.nan)
    if gap and gap.removable_closed is not None and gap.removable_closed_interval:
        closed = (gap.removable_closed, *gap.removable_closed_interval)
    if gap and gap.reduction_mm:
        reduction = gap.reduction_mm
    if gap and gap.landing:
        landing = (gap.landing.before_mm, gap.landing.after_mm, gap.landing.floor_mm)
    return {
        "shots": len(diagnosis.case.shots),
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
    estimate = with_unit(cause.estimate, cause.unit)
    return f"{cause.identity}{others} {estimate} ({interval_text(cause.interval)})"


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
