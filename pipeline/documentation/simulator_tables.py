"""Tables of published models, and of scenes that were diagnosed and amended."""

from pathlib import Path

from pipeline.documentation.cells import number
from pipeline.io.artifacts import read_json
from pipeline.io.markdown import markdown_table

SIMULATORS = Path("reports") / "simulators"


def scenes_table(root: Path) -> str:
    """What is wrong with each scene, what is named, and errors in its own engine, by engine."""
    rows = []
    for engine, scenes in read_json(root / SIMULATORS / "scenes.json").items():
        for one in scenes.values():
            leading = ", ".join(f"`{name}`" for name in one["leading"]) or "–"
            errors = (number(one[f"{when}_mm"]) for when in ("before", "after"))
            right = "yes" if one["named_right"] else "no"
            closed = f"{100 * one['removable_closed']:.1f} %"
            rows.append([engine, one["hidden"], leading, right, *errors, closed])
    heads = ["leading causes", "right", "before (mm)", "after (mm)", "gap closed"]
    return markdown_table(["engine", "what is wrong", *heads], rows)


def published_table(root: Path) -> str:
    """What published models say and do: their traps, and their values."""
    rows = []
    for name, one in read_json(root / SIMULATORS / "published.json").items():
        values = ", ".join(f"`{each['identity']}` {each['value']:g}" for each in one["effects"])
        sentences = [
            each["sentence"]
            + (f" {each['cost_mm']:.0f} mm after 0.4 s." if each["cost_mm"] is not None else "")
            for each in one["traps"]
        ]
        place = f"[{name}](https://github.com/{name}), {one['file']}"
        rows.append([place, one["says"], " ".join(sentences), values])
    return markdown_table(["model", "says", "traps", "does"], rows)
