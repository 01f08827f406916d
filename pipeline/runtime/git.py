"""What git knows of a repository."""

import subprocess
from pathlib import Path


def git(root: Path, *words: str) -> str | None:
    """What a git command prints, without white space at the ends; None where it fails."""
    done = subprocess.run(["git", *words], cwd=root, capture_output=True, text=True, check=False)
    return None if done.returncode else done.stdout.strip()


def git_commit(root: Path) -> str | None:
    """The commit that is checked out, or None outside git."""
    return git(root, "rev-parse", "--verify", "--quiet", "HEAD")
