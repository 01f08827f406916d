"""Disks that are full or cannot be written to, mounted for a while over a folder; needs root."""

import os
import shutil
import subprocess
import tempfile
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

LEFT = 16 * 1024  # bytes


def may_mount() -> bool:
    """Whether this process may mount file systems."""
    if shutil.which("mount") is None:
        return False
    with tempfile.TemporaryDirectory() as folder:
        tried = subprocess.run(["mount", "-t", "tmpfs", "tmpfs", folder], capture_output=True)
        if tried.returncode == 0:
            _run("umount", folder)
    return tried.returncode == 0


@contextmanager
def full_disk(folder: Path) -> Iterator[None]:
    """A disk under ``folder`` with nearly no room left; what was written to it stays."""
    folder.mkdir(parents=True, exist_ok=True)
    before, after = (folder.with_name(f".{folder.name}.{when}") for when in ("before", "after"))
    shutil.copytree(folder, before)
    _run("mount", "-t", "tmpfs", "-o", f"size={_size(folder) + LEFT}", "tmpfs", str(folder))
    try:
        shutil.copytree(before, folder, dirs_exist_ok=True)
        yield
        shutil.copytree(folder, after)
    finally:
        _run("umount", "--lazy", str(folder))
        shutil.rmtree(before)
    shutil.rmtree(folder)
    after.rename(folder)


@contextmanager
def read_only_disk(folder: Path) -> Iterator[None]:
    """A disk under ``folder`` to which nothing can be written."""
    _run("mount", "--bind", str(folder), str(folder))
    try:
        _run("mount", "-o", "remount,bind,ro", str(folder))
        yield
    finally:
        _run("umount", "--lazy", str(folder))


def _size(folder: Path) -> int:
    """Bytes that files below a folder take, in pages as a tmpfs counts them; folders take none."""
    page = os.sysconf("SC_PAGE_SIZE")
    files = (path for path in folder.rglob("*") if path.is_file())
    return sum(-(-path.stat().st_size // page) * page for path in files)


def _run(*command: str) -> None:
    subprocess.run(command, check=True)
