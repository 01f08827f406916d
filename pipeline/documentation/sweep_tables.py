"""Table of the committed sweeps."""

from collections.abc import Mapping
from pathlib import Path
from typing import Any

from pipeline.documentation.cells import NONE, number, with_interval
from pipeline.io.artifacts import read_json
from pipeline.io.markdown import markdown_table

HEADS = ["sweep", "trials (pruned)", "score", "`params.yaml`", "best trial"]
CONFIRMED_HEADS = ["confirmed", "`params.yaml`", "sweep", "difference (95 % interval)", "holds"]


def committed_sweeps(root: Path) -> str:
    """Scores of the committed sweeps, and what their confirmation measured."""
    folders = [path.parent for path in sorted((root / "reports/sweeps").glob("*/sweep.json"))]
    rows = [[*_searched(folder), *_confirmed(folder / "confirmed.json")] for folder in folders]
    return markdown_table([*HEADS, *CONFIRMED_HEADS], rows)


def _searched(folder: Path) -> list[str]:
    found = read_json(folder / "sweep.json")
    counts: Mapping[str, int] = found["trials"]
    trials = f"{sum(counts.values())} ({counts.get('pruned', 0)})"
    scores = [number(found[key]) for key in ("params_score", "best_score")]
    return [f"`{found['sweep']}`", trials, found["score"], *scores]


def _confirmed(path: Path) -> list[str]:
    """Return dashes for a sweep without a trial that is better than ``params.yaml``."""
    if not path.is_file():
        return [NONE] * len(CONFIRMED_HEADS)
    found: dict[str, Any] = read_json(path)
    difference = with_interval(found["difference"], found["ci_low"], found["ci_high"], ".3f")
    means = [number(found[key]) for key in ("params", "found")]
    return [found["measure"], *means, difference, "yes" if found["holds"] else "no"]
