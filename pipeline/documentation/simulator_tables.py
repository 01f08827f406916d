"""Table of published models."""

from pathlib import Path

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
