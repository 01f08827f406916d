"""Verdicts on many cases as tables."""

from collections import Counter
from collections.abc import Iterator, Sequence
from typing import Any

import numpy as np
import pandas as pd

from models.gap.verdict import Cause, Gap
from pipeline.gap.cases import Diagnosed
from pipeline.gap.wording import label, number, with_unit

CASE = ["source", "simulator", "split"]
CAUSE = ["cause", "parameter", "kind", "unit", "nominal"]
CLOSED = ["removable_closed", "closed_low", "closed_high"]
CLOSER = ["closer_low_mm", "closer_high_mm"]
LANDING = ["landing_before_mm", "landing_after_mm", "landing_floor_mm"]
ERRORS = [
    "horizon_ms",
    *("before_mm", "before_low", "before_high"),
    *("after_mm", "after_low", "after_high"),
    "floor_mm",
]
FIRST_MS, LAST_MS = 100, 300  # horizons between which errors are told


def verdict_table(found: Sequence[Diagnosed]) -> pd.DataFrame:
    """Return one row a case: what the verdict is, with its causes in words."""
    return pd.DataFrame([{**_case(one), **_verdict(one)} for one in found])


def cause_table(found: Sequence[Diagnosed]) -> pd.DataFrame:
    """Return one row a cause of a case, in numbers."""
    rows = [{**_case(one), **_cause(cause)} for one in found for cause in one.verdict.effects]
    numbers = ["estimate", "low", "high", "p_value", "gap_share", "possible"]
    return pd.DataFrame(rows, columns=[*CASE, *CAUSE, *numbers])


def error_table(found: Sequence[Diagnosed]) -> pd.DataFrame:
    """Return one row a case and horizon: errors on shots that naming never saw."""
    rows = [
        {**_case(one), **row}
        for one in found
        if one.verdict.gap
        for row in _errors(one.verdict.gap)
        if FIRST_MS <= row["horizon_ms"] <= LAST_MS
    ]
    return pd.DataFrame(rows, columns=[*CASE, *ERRORS])


def stability_table(found: Sequence[Diagnosed]) -> pd.DataFrame:
    """Return one row a source, simulator and cause: in how many splits it was found, and how large.

    ``verdicts`` counts what the splits say in one word; a source and simulator without any cause
    has a row of its own.
    """
    causes = cause_table(found)
    rows = []
    for setting, own in verdict_table(found).groupby(CASE[:2], sort=False):
        words = Counter(own["verdict"])
        row = {
            **dict(zip(CASE, setting, strict=False)),
            "verdicts": ", ".join(f"{count} {word}" for word, count in words.items()),
            "splits": len(own),
        }
        members = causes[(causes[CASE[:2]] == setting).all(axis=1)]
        rows += [{**row, **one} for one in _found_again(members)] or [row]
    columns = ["verdicts", "cause", "unit", "found", "splits", "estimate", "lowest", "highest"]
    return pd.DataFrame(rows, columns=[*CASE[:2], *columns])


def _found_again(causes: pd.DataFrame) -> list[dict[str, Any]]:
    return [
        {
            "cause": cause,
            "unit": unit,
            "found": len(own),
            "estimate": own["estimate"].mean(),
            "lowest": own["estimate"].min(),
            "highest": own["estimate"].max(),
        }
        for (cause, unit), own in causes.groupby(["cause", "unit"], sort=False)
    ]


def _errors(gap: Gap) -> Iterator[dict[str, float]]:
    for ms, before, within, after, then_within, floor in zip(
        gap.horizons_ms,
        gap.before_mm,
        gap.before_interval_mm,
        gap.after_mm,
        gap.after_interval_mm,
        gap.floor_mm,
        strict=True,
    ):
        values = (ms, before, *within, after, *then_within, floor)
        yield dict(zip(ERRORS, values, strict=True))


def _case(one: Diagnosed) -> dict[str, Any]:
    values = (one.case.source, one.case.begun, one.case.split)
    return dict(zip(CASE, values, strict=True))


def _verdict(one: Diagnosed) -> dict[str, Any]:
    verdict, gap = one.verdict, one.verdict.gap
    closed = landing = (np.nan, np.nan, np.nan)
    closer = (np.nan, np.nan)
    if gap and gap.removable_closed is not None and gap.interval:
        closed = (gap.removable_closed, *gap.interval)
    if gap and gap.closer_mm:
        closer = gap.closer_mm
    if gap and gap.landing:
        landing = (gap.landing.before_mm, gap.landing.after_mm, gap.landing.floor_mm)
    return {
        "shots": len(one.case.shots),
        "verdict": verdict.verdict,
        "causes": "; ".join(_words(cause) for cause in verdict.effects) or None,
        "unexplained": verdict.unexplained.share,
        **dict(zip(CLOSED, closed, strict=True)),
        **dict(zip(CLOSER, closer, strict=True)),
        **dict(zip(LANDING, landing, strict=True)),
    }


def _words(cause: Cause) -> str:
    low, high = cause.interval
    doubt = f" or {', '.join(cause.others)}" if cause.others else ""
    found = with_unit(cause.estimate, cause.unit)
    return f"{label(cause)}{doubt} {found} ({number(low)} to {number(high)})"


def _cause(cause: Cause) -> dict[str, Any]:
    return {
        "cause": label(cause),
        "parameter": cause.parameter,
        "kind": cause.kind,
        "unit": cause.unit,
        "nominal": cause.nominal,
        "estimate": cause.estimate,
        "low": cause.interval[0],
        "high": cause.interval[1],
        "p_value": cause.p_value,
        "gap_share": cause.gap_share,
        "possible": ", ".join(cause.possible),
    }
