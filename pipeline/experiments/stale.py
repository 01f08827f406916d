"""Kept results that are older than the code: which commit they are of, and what changed since."""

import subprocess
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

from pipeline.io.artifacts import read_json

CODE = ("models", "pipeline", "stages")
NEVER_KEPT = "contents.json"  # of a stage's own report, which `dvc repro` keeps up to date


@dataclass(frozen=True)
class KeptResult:
    """A folder of results that `dvc repro` does not write.

    Attributes:
        folder: below the repository.
        commit: of the code that wrote it.
        date: of that commit; None where this clone does not have it, as a shallow one.
        changed: packages that differ from that commit.
    """

    folder: Path
    commit: str
    date: str | None
    changed: tuple[str, ...]

    @property
    def is_stale(self) -> bool:
        """Whether the code has changed since, or nobody can tell."""
        return self.date is None or bool(self.changed)

    @property
    def sentence(self) -> str:
        """What a page that quotes the results says of their age."""
        if self.date is None:
            return f"Results of commit {self.commit[:7]}, which this clone does not have."
        age = "the code has changed since" if self.changed else "the code of today"
        return f"Results of commit {self.commit[:7]} ({self.date}), {age}."


def kept_results(root: Path) -> Iterator[KeptResult]:
    """Yield the kept results of a repository, by name.

    Args:
        root: the repository.
    """
    for path in sorted((root / "reports").glob("*")):
        if not path.is_dir() or (path / NEVER_KEPT).exists():
            continue
        # A sweep has a folder of its own below the others.
        folders = [path] if list(path.glob("*.*")) else sorted(path.glob("*/"))
        for folder in folders:
            if commit := _commit(root, folder):
                yield kept_result(root, folder, commit)


def kept_result(root: Path, folder: Path, commit: str) -> KeptResult:
    """Compare the code of a commit, which wrote a folder, with the working directory."""
    date = _git(root, "show", "--no-patch", "--format=%cs", commit) or None
    names = _git(root, "diff", "--name-only", commit, "--", *CODE).split() if date else []
    packages = {"/".join(Path(name).parts[:2]) for name in names}
    return KeptResult(folder.relative_to(root), commit, date, tuple(sorted(packages)))


def age_sentence(root: Path, folder: Path) -> str:
    """What a page that quotes the results of a folder says of their age; nothing outside git."""
    commit = _commit(root, folder)
    return kept_result(root, folder, commit).sentence if commit else ""


def _commit(root: Path, folder: Path) -> str | None:
    """The commit that a folder's run.json names, or else the one that last changed the folder."""
    record = folder / "run.json"
    if record.is_file():
        return str(read_json(record)["commit"])
    return _git(root, "log", "-1", "--format=%H", "--", str(folder)) or None


def _git(root: Path, *words: str) -> str:
    """What git prints; nothing where it fails."""
    command = ["git", *words]
    return subprocess.run(
        command, cwd=root, capture_output=True, text=True, check=False
    ).stdout.strip()
