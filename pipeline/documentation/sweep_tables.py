"""Tables of the committed sweeps."""

from pathlib import Path

from rallygap.pipeline.documentation.cells import number, with_interval
from rallygap.pipeline.io.artifacts import read_json
from rallygap.pipeline.io.markdown import markdown_table

SEARCHED = ["sweep", "trials", "pruned", "score", "`params.yaml`", "best trial"]
CONFIRMED = ["sweep", "measure", "`params.yaml`", "best trial", "difference (95 %)", "holds"]


def committed_sweeps(root: Path) -> str:
    """Scores of the committed sweeps."""
    rows = []
    for path in _files(root, "sweep.json"):
        found = read_json(path)
        counts = found["trials"]
        scores = [number(found[key]) for key in ("params_score", "best_score")]
        numbers = [str(sum(counts.values())), str(counts.get("pruned", 0))]
        rows.append([f"`{found['sweep']}`", *numbers, found["score"], *scores])
    return markdown_table(SEARCHED, rows)


def confirmed_sweeps(root: Path) -> str:
    """The first measure of every committed confirmation."""
    rows = []
    for path in _files(root, "confirmed.json"):
        found = read_json(path)
        means = [number(found[key]) for key in ("params", "found")]
        difference = with_interval(found["difference"], found["ci_low"], found["ci_high"], ".3f")
        holds = "yes" if found["holds"] else "no"
        rows.append([f"`{found['sweep']}`", found["measure"], *means, difference, holds])
    return markdown_table(CONFIRMED, rows)


def _files(root: Path, name: str) -> list[Path]:
    return sorted((root / "reports" / "sweeps").glob(f"*/{name}"))
