"""A repository of its own with all that git knows of this one, for tests that run DVC in it."""

import os
import shutil
import subprocess
import sys
from pathlib import Path

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
    """Make the repository, without any result, and commit; return its folder."""
    listed = subprocess.run(
        ["git", "ls-files", "-z", "--cached", "--others", "--exclude-standard"],
        cwd=ROOT, capture_output=True, text=True, check=True,
    ).stdout  # fmt: skip
    for name in listed.split("\0"):
        result = name.startswith(("reports/", "dvc.lock")) and not name.startswith(KEPT)
        if ((ROOT / name).is_file() or (ROOT / name).is_symlink()) and not result:
            (folder / name).parent.mkdir(parents=True, exist_ok=True)
            shutil.copy(ROOT / name, folder / name, follow_symlinks=False)
    run(folder, "git", "init", "--quiet")
    commit(folder, "start")
    return folder


def commit(folder: Path, message: str) -> None:
    """Commit all that has changed."""
    run(folder, "git", "add", ".")
    run(folder, "git", "commit", "--quiet", f"--message={message}")


def run(folder: Path, *command: str, below: str = ".") -> str:
    """Run a command as a user in the repository, or in a folder below, would; return its output."""
    done = subprocess.run(
        command, cwd=folder / below, env=environment(folder), capture_output=True, text=True
    )
    assert done.returncode >= 0, f"died of signal {-done.returncode}"
    assert done.returncode == 0, done.stdout + done.stderr
    return done.stdout


def environment(folder: Path) -> dict[str, str]:
    """The variables with which commands run the repository's code, and keep runs in it."""
    path = f"{Path(sys.executable).parent}:{os.environ['PATH']}"
    own = {key: text for key, text in os.environ.items() if key != "MLFLOW_TRACKING_URI"}
    return {**own, **IDENTITY, "PATH": path, "PYTHONPATH": str(folder)}


def rallygap(folder: Path, *words: str, below: str = ".") -> str:
    """Run our command line in the repository, or in a folder below; return what it printed."""
    program = "from rallygap.pipeline.cli import main; main()"
    return run(folder, "python", "-c", program, *words, below=below)
