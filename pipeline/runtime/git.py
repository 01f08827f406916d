"""What git knows of a repository."""

import subprocess
from pathlib import Path

from rallygap.pipeline.runtime.errors import InputError


def git(root: Path, *words: str) -> str:
    """What a git command prints.

    Raises:
        InputError: it fails.
    """
    done = subprocess.run(["git", *words], cwd=root, capture_output=True, text=True, check=False)
    if done.returncode:
        raise InputError(root, " ".join(done.stderr.split()))
    return done.stdout


def git_if_known(root: Path, *words: str) -> str | None:
    """What a git command prints, without white space at the ends; None where it fails."""
    try:
        return git(root, *words).strip()
    except InputError:
        return None


def git_commit(root: Path) -> str | None:
    """The commit that is checked out, or None outside git."""
    return git_if_known(root, "rev-parse", "--verify", "--quiet", "HEAD")
