"""Kept results that are older than the code: which commit they are of, and what changed since."""

from collections.abc import Iterable
from dataclasses import dataclass
from pathlib import Path

from rallygap.pipeline.experiments.file_content import do_the_same
from rallygap.pipeline.experiments.imports import imported_packages
from rallygap.pipeline.io.artifacts import read_json
from rallygap.pipeline.paper.run_reports import RECORD
from rallygap.pipeline.params import read_yaml
from rallygap.pipeline.runtime.errors import InputError
from rallygap.pipeline.runtime.git import git, git_commit, git_if_known

SETTINGS = ("params.yaml", "profiles")
EXAM = "hidden_effects"  # the stage whose results are the same in all experiments
CODE = ("models", "pipeline", "stages", "benchmarks", "dvc.yaml", *SETTINGS)
# What only presents results, or describes them: the schema is generated from code, which counts.
# These figures are drawn from tables: those of `pictures.DRAWN` by `rallygap docs`.
FIGURES = ("evaluation/figures", "swap_study/figures.py", "transfer/figures")
PRESENTATION = (
    *(f"pipeline/{name}" for name in ("documentation", "experiments", "paper", "print", "web")),
    *(f"pipeline/{name}" for name in FIGURES),
    "pipeline/cli.py",
    "models/gap/verdict.schema.json",
)


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
        if not self.commit:
            return "Results of a commit that nobody noted."
        if self.date is None:
            return f"Results of commit {self.commit[:7]}, which this clone does not have."
        age = "the code has changed since" if self.changed else "the code has not changed since"
        return f"Results of commit {self.commit[:7]} ({self.date}); {age}."


def kept_result(root: Path, folder: Path) -> KeptResult:
    """Compare the code that wrote a folder with the working directory.

    Its commit is the one that its run.json names, or else the one that last changed the folder.
    """
    record = folder / RECORD
    if record.is_file():
        commit = str(read_json(record)["commit"])
    else:
        commit = git_if_known(root, "log", "-1", "--format=%H", "--", str(folder)) or ""
    return result_of(root, folder, commit, code_of(kept_modules(root)))


def stage_modules(root: Path) -> list[str]:
    """Return the modules of the stages."""
    return [f"rallygap.stages.{name}" for name in read_yaml(root / "dvc.yaml")["stages"]]


def kept_modules(root: Path) -> list[str]:
    """Return the modules of the stages whose results kept runs have."""
    return [name for name in stage_modules(root) if name != f"rallygap.stages.{EXAM}"]


def code_of(entries: Iterable[str], files: Iterable[str] = SETTINGS) -> tuple[str, ...]:
    """Return what results depend on, but for presentation.

    Args:
        entries: the modules that make them.
        files: other paths.
    """
    packages = sorted(imported_packages(entries))
    code = (*packages, *(f"{one}.py" for one in packages))
    return (*(one for one in code if one not in PRESENTATION), *files)


def result_of(root: Path, folder: Path, commit: str, code: Iterable[str] = CODE) -> KeptResult:
    """Compare the code of a commit, whose results a folder has, with the working directory.

    Args:
        root: of the repository.
        folder: of the results.
        commit: that made them; empty where nobody knows.
        code: paths that they depend on.
    """
    date = git_if_known(root, "show", "--no-patch", "--format=%cs", commit) if commit else None
    packages = changed_code(root, commit, code) if date else ()
    return KeptResult(folder.relative_to(root), commit, date or None, packages)


def changed_code(root: Path, commit: str, code: Iterable[str] = CODE) -> tuple[str, ...]:
    """Return the packages of some code that differ from a commit, but for presentation.

    Comments and docstrings may differ.
    """
    left_out = [f":(exclude){path}" for path in PRESENTATION]
    names = git_if_known(root, "diff", "--name-only", commit, "--", *code, *left_out) or ""
    changed: set[str] = set()
    for name in names.split():
        package = str(_package(root, Path(name)))
        # One file settles it: git takes milliseconds to show each.
        if package not in changed and not _does_the_same(root, commit, name):
            changed.add(package)
    return tuple(sorted(changed))


def _does_the_same(root: Path, commit: str, name: str) -> bool:
    """Whether a file that differs from a commit's does the same."""
    before, file = git_if_known(root, "show", f"{commit}:{name}"), root / name
    if before is None or not file.is_file():
        return False
    return do_the_same(name, before, file.read_text(encoding="utf-8").strip())


def check_committed(root: Path) -> str | None:
    """Return the commit of the code; None outside git.

    Raises:
        InputError: no commit has the code as it is.
    """
    commit = git_commit(root)
    if commit is None:
        return None
    new = git(root, "ls-files", "--others", "--exclude-standard", "--", *CODE)
    if new or changed_code(root, commit):
        raise InputError(root, "has code that is not committed; results name a commit")
    return commit


def _package(root: Path, file: Path) -> Path:
    package = Path(*file.parts[:2])
    above = package.parent if package.parent.parts else package
    return package if (root / package).is_dir() else above
