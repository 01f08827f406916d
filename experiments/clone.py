"""Copies of this repository, to run pipelines in and to inject faults into."""

import os
import shutil
import subprocess
import sys
from pathlib import Path

import yaml

from rallygap.pipeline.params import read_yaml
from rallygap.pipeline.profiles import merged
from rallygap.pipeline.runtime.errors import InputError
from rallygap.pipeline.runtime.git import git

ROOT = Path(__file__).parents[1]
# Of experiments, which take hours.
KEPT = tuple(
    f"reports/{name}/"
    for name in (
        "exam", "arenas", "learning_curves", "real_forecasts", "spread_policies", "swap_study",
    )
)  # fmt: skip
IDENTITY = {
    f"GIT_{who}_{what}": text
    for who in ("AUTHOR", "COMMITTER")
    for what, text in {"NAME": "a", "EMAIL": "a@example.org"}.items()
}


def cloned(folder: Path) -> Path:
    """Make a repository with what git knows of this one, without results, and commit."""
    copy_sources(ROOT, folder)
    run(folder, "git", "init", "--quiet")
    commit(folder, "start")
    return folder


def small_clone(folder: Path) -> Path:
    """Make such a repository with the parameters of the profile `smoke`."""
    cloned(folder)
    params = read_yaml(folder / "params.yaml")
    params = merged(params, read_yaml(folder / "experiments" / "profiles" / "smoke.yaml"))
    (folder / "params.yaml").write_text(yaml.safe_dump(params, sort_keys=False))
    commit(folder, "small")
    return folder


def copy_sources(root: Path, folder: Path) -> None:
    """Copy what git knows of a repository, as it is, without results of its pipeline.

    Args:
        root: the repository.
        folder: the copy; files that are there are replaced, links stay.

    Raises:
        InputError: ``root`` is no repository.
    """
    listed = git(root, "ls-files", "-z", "--cached", "--others", "--exclude-standard")
    if listed is None:
        raise InputError(root, "is no repository of git")
    for name in filter(None, listed.split("\0")):
        source, target = root / name, folder / name
        result = name.startswith(("reports/", "dvc.lock")) and not name.startswith(KEPT)
        if (source.is_symlink() or source.is_file()) and not result:
            target.parent.mkdir(parents=True, exist_ok=True)
            if not target.is_symlink():
                shutil.copy(source, target, follow_symlinks=False)


def commit(folder: Path, message: str) -> None:
    """Commit all that has changed."""
    run(folder, "git", "add", ".")
    run(folder, "git", "commit", "--quiet", f"--message={message}")


def run(folder: Path, *command: str, below: str = ".") -> str:
    """Run a command as a user in the repository, or in a folder below, would; return its output.

    Raises:
        RuntimeError: it fails, or dies of a signal.
    """
    done = subprocess.run(
        command, cwd=folder / below, env=environment(folder), capture_output=True, text=True
    )
    if done.returncode:
        raise RuntimeError(f"{command} ends with {done.returncode}: {done.stdout}{done.stderr}")
    return done.stdout


def environment(folder: Path) -> dict[str, str]:
    """The variables with which commands run the repository's code, and keep runs in it."""
    path = f"{Path(sys.executable).parent}:{os.environ['PATH']}"
    own = {
        key: text
        for key, text in os.environ.items()
        if key != "MLFLOW_TRACKING_URI" and not key.startswith("DVC_")  # of an outer `dvc repro`
    }
    return {**own, **IDENTITY, "PATH": path, "PYTHONPATH": str(folder)}


def rallygap(folder: Path, *words: str, below: str = ".") -> str:
    """Run our command line in the repository, or in a folder below; return what it printed."""
    program = "from rallygap.pipeline.cli import main; main()"
    return run(folder, "python", "-c", program, *words, below=below)
