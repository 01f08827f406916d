"""Where results are to go, checked before the work begins rather than after it."""

import os
from pathlib import Path

from pipeline.runtime.errors import InputError


def check_folder(folder: Path) -> None:
    """Raise unless a folder can be written to, or made.

    Raises:
        InputError: it is a file or below one, or this user may not write there.
    """
    there = next(one for one in (folder.absolute(), *folder.absolute().parents) if one.exists())
    if not there.is_dir():
        where = folder if folder.exists() else there
        raise InputError(where, "is a file; give a folder to write to")
    if not os.access(there, os.W_OK | os.X_OK):
        raise InputError(folder, "cannot be written to by this user; give another folder")


def check_file(path: Path) -> None:
    """Raise unless a file can be written.

    Raises:
        InputError: it is a folder, or its folder cannot be written to.
    """
    if path.is_dir():
        raise InputError(path, "is a folder; give a file to write")
    check_folder(path.parent)
