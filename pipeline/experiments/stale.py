"""Kept results that are older than the code: which commit they are of, and what changed since."""

from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

from pipeline.io.artifacts import read_json
from pipeline.paper.run_reports import RECORD
from pipeline.runtime.git import git_if_known

CODE = ("models", "pipeline", "stages")
NEVER_KEPT = "contents.json"  # of a stage's own report, which `dvc repro` keeps up to date


@dataclass(frozen=True)
class KeptResult:
    """A folder of results that `dvc repro` does not write.

    Attributes:
        folder: below the repository.
        commit: of the code that wrote it; empty where git has none.
        date: of that commit; None where this clone does not have it, as a shallow one.
        changed: packages of today that differ from that commit; the folder above for former ones.
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
    """Yield the kept and committed results of a repository, by name."""
    for path in sorted((root / "reports").glob("*")):
        if not path.is_dir() or (path / NEVER_KEPT).exists():
            continue
        # A sweep has a folder of its own below the others.
        folders = [path] if list(path.glob("*.*")) else sorted(path.glob("*/"))
        kept = (kept_result(root, folder) for folder in folders)
        yield from (one for one in kept if one.commit)


def kept_result(root: Path, folder: Path) -> KeptResult:
    """Compare the code that wrote a folder with the working directory.

    Its commit is the one that its run.json names, or else the one that last changed the folder.
    """
    record = folder / RECORD
    if record.is_file():
        commit = str(read_json(record)["commit"])
    else:
        commit = git_if_known(root, "log", "-1", "--format=%H", "--", str(folder)) or ""
    return result_of(root, folder, commit)


def result_of(root: Path, folder: Path, commit: str) -> KeptResult:
    """Compare the code of a commit, whose results a folder has, with the working directory."""
    date = git_if_known(root, "show", "--no-patch", "--format=%cs", commit) or None
    names = git_if_known(root, "diff", "--name-only", commit, "--", *CODE) if date else None
    packages = {str(_package(root, Path(name))) for name in (names or "").split()}
    return KeptResult(folder.relative_to(root), commit, date, tuple(sorted(packages)))


def _package(root: Path, file: Path) -> Path:
    package = Path(*file.parts[:2])
    return package if (root / package).is_dir() else package.parent
