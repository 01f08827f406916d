"""The repository that the user of the command line stands in, refused where it is none."""

from pathlib import Path

from pipeline.runtime.errors import InputError
from pipeline.runtime.provenance import repository_root


def clone() -> Path:
    """Return the repository that holds the working directory.

    Raises:
        InputError: the working directory is in none of rallygap's.
    """
    root = repository_root()
    if not (root / "params.yaml").is_file():
        problem = "is not within a clone of rallygap, which has a params.yaml; change into yours"
        raise InputError(root, problem)
    return root


def clone_with_run() -> Path:
    """Return the repository that holds the working directory, if there are artefacts in it.

    Raises:
        InputError: the working directory is in none of rallygap's, or nothing has run there.
    """
    root = clone()
    if not (root / "artifacts").is_dir():
        problem = "is missing, because nothing has run here; `make reproduce` runs everything"
        raise InputError(root / "artifacts", problem)
    return root
