"""The page's section on the paper: every number with ours, and both drawn on a scale."""

import math
import re
from collections import Counter
from collections.abc import Set
from dataclasses import dataclass
from typing import Any

from rallygap.pipeline.paper.assessments import MEANINGS
from rallygap.pipeline.paper.comparison import (
    CONTEXT,
    Finding,
    Group,
    exhibits,
    groups,
)
from rallygap.pipeline.paper.run_reports import Reports
from rallygap.pipeline.paper.values import Value

DECADES = 2.0  # of the scale on which sizes are drawn, on each side of the paper's


@dataclass(frozen=True)
class Mark:
    """Where things are drawn on a scale from 0 to 100; ``None`` is not drawn."""

    zero: float | None
    paper: float | None
    ours: float | None
    low: float | None
    high: float | None


def paper_section(run: Reports, anchors: Set[str]) -> dict[str, Any]:
    """Return what the template shows of the paper.

    Args:
        run: the reports that the page is about.
        anchors: of stages and of what they report, on the same page.
    """
    shown = [
        {
            "name": one.name,
            "what": one.what,
            "ours": _linked(one.ours, anchors),
            "assessment": one.assessment(run),
            "stage": one.stage,
        }
        for one in exhibits()
    ]
    return {
        "context": CONTEXT,
        "exhibits": shown,
        "groups": [_group(group, run) for group in groups()],
        "meanings": MEANINGS,
    }


def _linked(ours: str, anchors: Set[str]) -> list[tuple[str, str | None]]:
    """Return the parts of a list of files, each with its anchor where the page has it."""
    parts = re.split("([,;] )", ours)
    names = [part.rstrip("/") for part in parts]
    return [
        (part, name if name in anchors else None) for part, name in zip(parts, names, strict=True)
    ]


def mark(group: Group, value: Value, found: Finding) -> Mark:
    """Return where the paper's value and ours are drawn.

    Groups without an axis are drawn by their ratio, the paper's in the middle.
    """
    if group.axis is None:
        return _ratio(value.printed, found.value)
    low, high = group.axis

    def place(size: float | str | None) -> float | None:
        if not isinstance(size, int | float):
            return None
        return round(100 * min(max((size - low) / (high - low), 0.0), 1.0), 2)

    ends = (found.interval.low, found.interval.high) if found.interval else (None, None)
    zero = place(0.0) if low < 0 < high else None
    return Mark(zero, place(value.printed), place(found.value), *map(place, ends))


def _ratio(printed: float | str | None, ours: float | str | None) -> Mark:
    if not isinstance(printed, int | float) or not isinstance(ours, int | float):
        return Mark(None, None, None, None, None)
    decades = math.log10(ours / printed) if ours > 0 else -DECADES
    place = round(50 + 50 * min(max(decades / DECADES, -1.0), 1.0), 2)
    return Mark(None, 50.0, place, None, None)


def _group(group: Group, run: Reports) -> dict[str, Any]:
    rows = [
        {
            "what": value.what,
            "paper": value.printed_text,
            "ours": found.shown,
            "assessment": found.assessment,
            "mark": mark(group, value, found),
            "where": value.ours,
        }
        for value, found in group.findings(run)
    ]
    stages = dict.fromkeys(value.stage for value in group.values if value.stage)
    return {
        "key": group.id,
        "title": group.title,
        "about": group.about,
        "scale": _scale(group),
        "rows": rows,
        "counts": dict(Counter(row["assessment"] for row in rows)),
        "stages": list(stages),
    }


def _scale(group: Group) -> str:
    if group.axis is None:
        return "ours divided by the paper's, 1/100 to 100"
    unit = group.values[0].unit
    low, high = group.axis
    return f"{low:g} to {high:g} {unit}"
