"""The repository that a command works in, and checks of folders to write to."""

import os
from pathlib import Path

from rallygap.pipeline.runtime.errors import InputError


def repository_root() -> Path:
    """The repository, whatever the working directory.

    DVC runs an experiment in a temporary copy of the repository and names the real one in DVC_ROOT.
    Elsewhere it is the nearest folder that holds pyproject.toml, or else the working directory.
    """
    if "DVC_ROOT" in os.environ:
        return Path(os.environ["DVC_ROOT"])
    here = Path.cwd()
    return next(
        (folder for folder in (here, *here.parents) if (folder / "pyproject.toml").is_file()), here
    )


def clone() -> Path:
    """The clone of rallygap that holds the working directory.

    Raises:
        InputError: the working directory is in none.
    """
    root = repository_root()
    if not (root / "params.yaml").is_file():
        problem = "is not within a clone of rallygap, which has a params.yaml; change into yours"
        raise InputError(root, problem)
    return root


def clone_with_run() -> Path:
    """The clone of rallygap that holds the working directory, if there are artefacts in it.

    Raises:
        InputError: the working directory is in none, or no stage has run there.
    """
    root = clone()
    if not (root / "artifacts").is_dir():
        problem = "is missing, because nothing has run here; `make reproduce` runs everything"
        raise InputError(root / "artifacts", problem)
    return root


def measured_sets() -> Path:
    """The folder with the measured sets, from the environment variable RALLYGAP_DATA.

    Raises:
        InputError: it is not set, or is no folder.
    """
    folder = os.environ.get("RALLYGAP_DATA", "")
    if not folder or not Path(folder).is_dir():
        problem = "is not a folder; set it to the one that holds spindoe, tt3d, …"
        raise InputError("RALLYGAP_DATA", problem)
    return Path(folder)


def check_folder(folder: Path) -> None:
    """Raise unless a folder can be written to, or made.

    Raises:
        InputError: it is a file or below one, or this user may not write there.
    """
    nearest = next(
        path for path in (folder.absolute(), *folder.absolute().parents) if path.exists()
    )
    if not nearest.is_dir():
        where = folder if folder.exists() else nearest
        raise InputError(where, "is a file; give a folder to write to")
    if not os.access(nearest, os.W_OK | os.X_OK):
        raise InputError(folder, "cannot be written to by this user; give another folder")


def check_file(path: Path) -> None:
    """Raise unless a file can be written.

    Raises:
        InputError: it is a folder, or its folder cannot be written to.
    """
    if path.is_dir():
        raise InputError(path, "is a folder; give a file to write")
    check_folder(path.parent)
