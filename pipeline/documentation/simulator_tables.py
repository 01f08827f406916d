"""Tables of scenes that were diagnosed and amended."""

from pathlib import Path

from pipeline.documentation.cells import number
from pipeline.io.artifacts import read_json
from pipeline.io.markdown import markdown_table

SCENES = Path("reports") / "simulators" / "scenes.json"


def scenes_table(root: Path) -> str:
    """What is wrong with each scene, what is named, and errors in its own engine, by engine."""
    rows = []
    for engine, scenes in read_json(root / SCENES).items():
        for one in scenes.values():
            leading = ", ".join(f"`{name}`" for name in one["leading"]) or "–"
            errors = (number(one[f"{when}_mm"]) for when in ("before", "after"))
            right = "yes" if one["named_right"] else "no"
            closed = f"{100 * one['removable_closed']:.1f} %"
            rows.append([engine, one["hidden"], leading, right, *errors, closed])
    heads = ["leading causes", "right", "before (mm)", "after (mm)", "gap closed"]
    return markdown_table(["engine", "what is wrong", *heads], rows)
