"""Tables of published models, and of lists that go into scenes and come back."""

from pathlib import Path
from typing import Any

from pipeline.documentation.cells import NONE
from pipeline.engines.audit_text import with_cost
from pipeline.io.artifacts import read_json
from pipeline.io.markdown import markdown_table

SIMULATORS = Path("reports") / "simulators"


def published_table(root: Path) -> str:
    """What published models say and do: their traps, and their values."""
    rows = []
    for name, one in read_json(root / SIMULATORS / "published.json").items():
        values = ", ".join(f"`{each['identity']}` {each['value']:g}" for each in one["effects"])
        sentences = [with_cost(each["sentence"], each["cost_mm"]) for each in one["traps"]]
        place = f"[{name}](https://github.com/{name}), {one['file']}"
        rows.append([place, one["says"], " ".join(sentences), values])
    return markdown_table(["model", "says", "traps", "does"], rows)


def round_trip_table(root: Path) -> str:
    """Largest differences of lists that go into scenes and come back: parameters by kinds."""
    report = read_json(root / SIMULATORS / "round_trip.json")
    kinds = report["kinds"]
    first = next(iter(kinds.values()))["parameters"]
    names = [
        *first,
        *sorted({name for one in kinds.values() for name in one["parameters"]} - {*first}),
    ]
    heads = [f"{name} ({one['lists']} lists)" for name, one in kinds.items()]
    rows = [
        [f"`{name}`", *(_difference(one["parameters"].get(name)) for one in kinds.values())]
        for name in names
    ]
    return markdown_table(["parameter", *heads], rows)


def without_attribute(root: Path) -> str:
    """Parameters without attribute, and in how many lists the export names them."""
    report = read_json(root / SIMULATORS / "round_trip.json")
    return ", ".join(
        f"`{name}` {one['named']} of {one['lists']}"
        for name, one in report["without_attribute"].items()
    )


def _difference(found: dict[str, Any] | None) -> str:
    """Return a largest difference in percent, in bold where it misses the target."""
    if found is None:
        return NONE
    share = found["largest_difference"]
    shown = f"{100 * share:.3g} %" if share else "< 0.001 %"
    return shown if found["within_target"] else f"**{shown}**"
