"""Kept results that are older than the code: which commit they are of, and what changed since."""

from dataclasses import dataclass
from pathlib import Path

from pipeline.io.artifacts import read_json
from pipeline.paper.run_reports import RECORD
from pipeline.runtime.git import git_if_known

CODE = ("models", "pipeline", "stages", "params.yaml", "profiles")
# What only presents results.
PRESENTATION = ("documentation", "experiments", "paper", "print", "web", "cli.py")


@dataclass(frozen=True)
class KeptResult:
    """Results that the repository keeps.

    Attributes:
        folder: below the repository, or the name of a step of `make everything` in its place.
        commit: of the code that wrote it; empty where nobody knows.
        date: of that commit; None where this clone does not have it, as a shallow one.
        changed: packages of today that differ from that commit, without those that only present
            results; the folder above for former ones.
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
    date = git_if_known(root, "show", "--no-patch", "--format=%cs", commit) if commit else None
    packages = changed_code(root, commit) if date else ()
    return KeptResult(folder.relative_to(root), commit, date or None, packages)


def changed_code(root: Path, commit: str) -> tuple[str, ...]:
    """Return the packages that results can depend on and that differ from a commit."""
    left_out = [f":(exclude)pipeline/{name}" for name in PRESENTATION]
    names = git_if_known(root, "diff", "--name-only", commit, "--", *CODE, *left_out) or ""
    return tuple(sorted({str(_package(root, Path(name))) for name in names.split()}))


def _package(root: Path, file: Path) -> Path:
    package = Path(*file.parts[:2])
    above = package.parent if package.parent.parts else package
    return package if (root / package).is_dir() else above
