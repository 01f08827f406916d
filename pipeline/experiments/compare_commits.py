"""Compare the committed results of two commits number by number; text and names do not count.

A change of structure must leave every number as it is. Files that git sees as renamed are compared
with their former selves. Kept runs are records of their own commits and are left out.
"""

import io
import json
from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd

from rallygap.models.ball.types import Floats
from rallygap.pipeline.paper.run_reports import RECORD, is_record_of_run
from rallygap.pipeline.runtime.git import git

RESULTS = "reports/"
NOT_NUMBERS = "contents.json"  # what a report holds, with the fingerprint of its run


def compare_commits(root: Path, base: str, new: str) -> tuple[int, dict[str, str]]:
    """Compare the tables and metrics under ``reports/``.

    Returns:
        How many files were compared, and by path what differs.

    Raises:
        InputError: a commit is not known to git.
    """
    before, after = _files(root, base), _files(root, new)
    former = {path: path for path in before} | _renamed(root, base, new)
    pairs = {path: former[path] for path in sorted(after) if former.get(path) in before}
    differences = dict.fromkeys(sorted(after - {*pairs}), "added")
    differences |= dict.fromkeys(sorted(before - {*pairs.values()}), "removed")
    for path, earlier in pairs.items():
        what = _difference(_numbers(root, base, earlier), _numbers(root, new, path))
        if what:
            differences[path] = what
    return len(pairs), differences


def _difference(one: Floats, other: Floats) -> str | None:
    if len(one) != len(other):
        return f"{len(one)} numbers before, {len(other)} after"
    unequal = np.flatnonzero(~((one == other) | (np.isnan(one) & np.isnan(other))))
    if not len(unequal):
        return None
    first = unequal[0]
    return f"{len(unequal)} of {len(one)} numbers differ, first {one[first]:g} -> {other[first]:g}"


def _files(root: Path, commit: str) -> set[str]:
    """Return the tables and metrics of a commit, those of kept runs left out."""
    listed = git(root, "ls-tree", "-r", "--name-only", commit, RESULTS).splitlines()
    kept = tuple(_kept_runs(root, commit, listed))
    return {
        path
        for path in listed
        if path.endswith((".csv", ".json", ".jsonl"))
        and not path.endswith(NOT_NUMBERS)
        and not path.startswith(kept)
    }


def _kept_runs(root: Path, commit: str, listed: Sequence[str]) -> Iterator[str]:
    """Yield the folders of kept runs, each with a slash at its end."""
    for path in listed:
        folder, _, name = path.rpartition("/")
        if name == RECORD and is_record_of_run(json.loads(git(root, "show", f"{commit}:{path}"))):
            yield f"{folder}/"


def _renamed(root: Path, base: str, new: str) -> dict[str, str]:
    """Return the new path of every renamed file with its former one."""
    words = ("diff", "--name-status", "--find-renames=30%", "--diff-filter=R", base, new)
    lines = git(root, *words, "--", RESULTS).splitlines()
    return {after: before for _, before, after in (line.split("\t") for line in lines)}


def _numbers(root: Path, commit: str, path: str) -> Floats:
    content = git(root, "show", f"{commit}:{path}")
    if path.endswith(".csv"):
        table = pd.read_csv(io.StringIO(content)).select_dtypes(["number", "bool"])
        return np.asarray(table.to_numpy(np.float64).ravel())
    lines = content.splitlines() if path.endswith(".jsonl") else [content]
    return np.array([number for line in lines for number in _in_json(json.loads(line))])


def _in_json(value: Any) -> Iterator[float]:
    if isinstance(value, int | float):
        yield float(value)
    elif isinstance(value, dict | list):
        for item in value.values() if isinstance(value, dict) else value:
            yield from _in_json(item)
