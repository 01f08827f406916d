"""The page's section on the paper: every number with ours, and both drawn on a scale."""

import math
import re
from collections import Counter
from collections.abc import Set
from typing import Any, NamedTuple

from rallygap.pipeline.paper.assessments import MEANINGS, Finding
from rallygap.pipeline.paper.comparison import CONTEXT, Group, exhibits, groups
from rallygap.pipeline.paper.run_reports import Reports
from rallygap.pipeline.paper.values import Value

DECADES = 2.0  # of the scale on which sizes are drawn, on each side of the paper's


class Mark(NamedTuple):
    """Where things are drawn on a scale from 0 to 100; ``None`` is not drawn."""

    zero: float | None = None
    paper: float | None = None
    ours: float | None = None
    low: float | None = None
    high: float | None = None


def paper_section(run: Reports, anchors: Set[str]) -> dict[str, Any]:
    """Return what the template shows of the paper.

    Args:
        run: the reports that the page is about.
        anchors: of stages and of what they report, on the same page.
    """
    return {
        "context": CONTEXT,
        "exhibits": [
            exhibit._asdict()
            | {"ours": _linked(exhibit.ours, anchors), "assessment": exhibit.assessment(run)}
            for exhibit in exhibits()
        ],
        "groups": [_group(group, run) for group in groups()],
        "meanings": MEANINGS,
    }


def _linked(ours: str, anchors: Set[str]) -> list[tuple[str, str | None]]:
    """Return the parts of a list of files, each with its anchor where the page has it."""
    parts = [(part, part.rstrip("/")) for part in re.split("([,;] )", ours)]
    return [(part, name if name in anchors else None) for part, name in parts]


def _group(group: Group, run: Reports) -> dict[str, Any]:
    findings = group.findings(run)
    scale = "ours divided by the paper's, 1/100 to 100"
    if group.axis is not None:
        scale = f"{group.axis[0]:g} to {group.axis[1]:g} {group.values[0].unit}"
    return {
        "key": group.id,
        "title": group.title,
        "about": group.about,
        "scale": scale,
        "rows": [(value, finding, mark(group, value, finding)) for value, finding in findings],
        "counts": Counter(finding.assessment for _, finding in findings),
        "stages": list(dict.fromkeys(value.stage for value in group.values if value.stage)),
    }


def mark(group: Group, value: Value, found: Finding) -> Mark:
    """Return where the paper's value and ours are drawn.

    Groups without an axis are drawn by their ratio, the paper's in the middle.
    """
    printed, ours = value.printed, found.value
    if group.axis is None:
        if isinstance(printed, str | None) or isinstance(ours, str | None):
            return Mark()
        decades = math.log10(ours / printed) if ours > 0 else -DECADES
        return Mark(paper=50.0, ours=_place(decades, (-DECADES, DECADES)))
    sizes = (0.0, printed, ours, *(found.interval or (None, None, None))[1:])
    places = [None if isinstance(s, str | None) else _place(s, group.axis) for s in sizes]
    return Mark(*places) if group.axis[0] < 0 < group.axis[1] else Mark(None, *places[1:])


def _place(size: float, axis: tuple[float, float]) -> float:
    low, high = axis
    return round(100 * min(max((size - low) / (high - low), 0.0), 1.0), 2)
