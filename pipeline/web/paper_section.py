"""The page's section on the paper: every number beside ours, and the difference drawn."""

import math
import re
from collections.abc import Mapping, Sequence, Set
from dataclasses import dataclass
from typing import Any

from pipeline.io.report_manifest import Contents
from pipeline.paper.catalogue import EXHIBITS, GROUPS, OTHERS, findings
from pipeline.paper.entries import NOTHING, Entry, Finding, Group
from pipeline.paper.judgements import MEANINGS
from pipeline.paper.run_reports import Reports

DECADES = 2.0  # of the scale on which sizes are drawn, on each side of the paper's


@dataclass(frozen=True)
class Mark:
    """Where things are drawn on a scale from 0 to 100; ``None`` is not drawn."""

    zero: float | None
    paper: float | None
    ours: float | None
    low: float | None
    high: float | None


def paper_section(run: Reports, contents: Sequence[Contents]) -> dict[str, Any]:
    """Return what the template shows of the paper.

    Args:
        run: the reports that the page is about.
        contents: what the stages report, on the same page.
    """
    found = findings(run)
    fingerprints = {one.stage: one.fingerprint for one in contents}
    exhibits = [
        {
            "name": one.name,
            "what": one.what,
            "ours": _linked(one.ours, _anchors(contents)),
            "verdict": one.verdict(run),
            "stage": one.stage,
            "fingerprint": fingerprints.get(one.stage, ""),
        }
        for one in EXHIBITS
    ]
    groups = [_group(group, found, fingerprints) for group in GROUPS]
    return {"others": OTHERS, "exhibits": exhibits, "groups": groups, "meanings": MEANINGS}


def _anchors(contents: Sequence[Contents]) -> set[str]:
    """Return the anchors of stages and of what they report."""
    files = {f"{stage.stage}/{item.file}" for stage in contents for item in stage.items}
    return files | {stage.stage for stage in contents}


def _linked(ours: str, anchors: Set[str]) -> list[tuple[str, str | None]]:
    """Return the parts of a list of files, each with its anchor where the page has it."""
    parts = re.split("([,;] )", ours)
    names = [part.rstrip("/") for part in parts]
    return [
        (part, name if name in anchors else None) for part, name in zip(parts, names, strict=True)
    ]


def mark(group: Group, entry: Entry, found: Finding) -> Mark:
    """Return where the paper's value and ours are drawn.

    Groups without an axis are drawn by their ratio, the paper's in the middle.
    """
    if group.axis is None:
        return _ratio(entry.printed, found.value)
    low, high = group.axis

    def place(value: float | str | None) -> float | None:
        if not isinstance(value, int | float):
            return None
        return round(100 * min(max((value - low) / (high - low), 0.0), 1.0), 2)

    ends = (found.interval.low, found.interval.high) if found.interval else (None, None)
    zero = place(0.0) if low < 0 < high else None
    return Mark(zero, place(entry.printed), place(found.value), *map(place, ends))


def _ratio(printed: float | str | None, ours: float | str | None) -> Mark:
    if not isinstance(printed, int | float) or not isinstance(ours, int | float):
        return Mark(None, None, None, None, None)
    decades = math.log10(ours / printed) if ours > 0 else -DECADES
    place = round(50 + 50 * min(max(decades / DECADES, -1.0), 1.0), 2)
    return Mark(None, 50.0, place, None, None)


def _group(
    group: Group, found: Mapping[str, Finding], fingerprints: Mapping[str, str]
) -> dict[str, Any]:
    rows = [
        {
            "what": entry.what,
            "paper": entry.paper,
            "ours": entry.ours(found[entry.key]),
            "verdict": found[entry.key].verdict,
            "mark": mark(group, entry, found[entry.key]),
            "where": entry.where,
        }
        for entry in group.entries
    ]
    stages = dict.fromkeys(entry.stage for entry in group.entries if entry.stage != NOTHING)
    return {
        "key": group.key,
        "title": group.title,
        "about": group.about,
        "scale": _scale(group),
        "rows": rows,
        "runs": [{"stage": one, "fingerprint": fingerprints.get(one, "")} for one in stages],
    }


def _scale(group: Group) -> str:
    if group.axis is None:
        return "ours over the paper's, 1/100 to 100"
    unit = group.entries[0].unit
    low, high = group.axis
    return f"{low:g} to {high:g} {unit}"
