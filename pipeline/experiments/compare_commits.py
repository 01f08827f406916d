"""Compare the committed results of two commits number by number; text and names do not count.

A change of structure must leave every number as it is. Tables and metrics are compared cell by
cell, files that git sees as renamed with their former selves. Kept runs are records of their own
commits and are left out.
"""

import io
import json
import subprocess
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path, PurePosixPath
from typing import Any

import numpy as np
import pandas as pd

from models.ball.types import Floats
from pipeline.runtime.errors import InputError

RESULTS = "reports"
NOT_NUMBERS = ("contents.json",)  # what a report holds, with the fingerprint of its run


@dataclass(frozen=True)
class FileDifference:
    """What differs in one file.

    Attributes:
        path: of the file.
        what: in words.
    """

    path: str
    what: str


def compare_commits(root: Path, base: str, new: str) -> tuple[int, list[FileDifference]]:
    """Compare the tables and metrics under ``reports/``.

    Returns:
        How many files were compared, and what differs.

    Raises:
        InputError: a commit is not known to git.
    """
    before, after = _files(root, base), _files(root, new)
    former = {path: path for path in before} | _renamed(root, base, new)
    pairs = {path: former[path] for path in sorted(after) if former.get(path) in before}
    differences = [FileDifference(path, "added") for path in sorted(after - {*pairs})]
    differences += [FileDifference(path, "removed") for path in sorted(before - {*pairs.values()})]
    for path, earlier in pairs.items():
        what = _difference(_numbers(root, base, earlier), _numbers(root, new, path))
        if what:
            differences.append(FileDifference(path, what))
    return len(pairs), differences


def _difference(one: Floats, other: Floats) -> str | None:
    if len(one) != len(other):
        return f"{len(one)} numbers before, {len(other)} after"
    unequal = ~((one == other) | (np.isnan(one) & np.isnan(other)))
    if not unequal.any():
        return None
    first = int(np.flatnonzero(unequal)[0])
    return f"{unequal.sum()} of {len(one)} numbers differ, first {one[first]:g} -> {other[first]:g}"


def _git(root: Path, *words: str) -> bytes:
    done = subprocess.run(["git", *words], cwd=root, capture_output=True, check=False)
    if done.returncode:
        raise InputError(" ".join(words), done.stderr.decode().strip().splitlines()[0])
    return done.stdout


def _files(root: Path, commit: str) -> set[str]:
    """Return the tables and metrics of a commit, those of kept runs left out."""
    listed = _git(root, "ls-tree", "-r", "--name-only", commit, f"{RESULTS}/").decode().splitlines()
    kept = {str(PurePosixPath(path).parent) for path in listed if path.endswith("/run.json")}
    return {
        path
        for path in listed
        if path.endswith((".csv", ".json", ".jsonl"))
        and not path.endswith(NOT_NUMBERS)
        and not any(path.startswith(f"{folder}/") for folder in kept)
    }


def _renamed(root: Path, base: str, new: str) -> dict[str, str]:
    """Return the new path of every renamed file with its former one."""
    words = ("diff", "--name-status", "--find-renames=30%", "--diff-filter=R", base, new)
    lines = _git(root, *words, "--", RESULTS).decode().splitlines()
    return {after: before for _, before, after in (line.split("\t") for line in lines)}


def _numbers(root: Path, commit: str, path: str) -> Floats:
    content = _git(root, "show", f"{commit}:{path}")
    if path.endswith(".csv"):
        table = pd.read_csv(io.BytesIO(content)).select_dtypes("number")
        return np.asarray(table.to_numpy(np.float64).ravel())
    lines = content.splitlines() if path.endswith(".jsonl") else [content]
    return np.array([number for line in lines for number in _in_json(json.loads(line))])


def _in_json(value: Any) -> Iterator[float]:
    if isinstance(value, int | float):
        yield float(value)
    elif isinstance(value, dict | list):
        for one in value.values() if isinstance(value, dict) else value:
            yield from _in_json(one)
