"""Removes what is damaged of DVC's: cached files with their copies among the outputs, its lock.

DVC trusts a cached file that is read-only. One that a disk has damaged is therefore checked out as
it is, even over the right one that a stage has just written, and DVC calls it up to date. What is
not there at all, DVC makes anew. Where it was killed while it noted what is in use, it would refuse
to run for ever.
"""

import hashlib
import json
from collections.abc import Iterator
from pathlib import Path

from pipeline.experiments.stage_outputs import stage_outputs
from pipeline.runtime.errors import InputError


def mend(root: Path) -> list[Path]:
    """Remove every damaged file of the cache, every output that is a copy of one, a broken lock.

    Returns:
        What was removed.

    Raises:
        InputError: it is no repository of DVC's, or dvc.lock is broken; nothing was removed.
    """
    cache, lock = _places(root)
    damaged = {path: digest for path, digest in _cached(cache) if digest != _named(path)}
    outputs = _outputs(root) if damaged else ()  # to read all of them takes long
    copies = [path for path in outputs if _digest(path) in damaged.values()]
    broken = [] if _whole(lock) else [lock]
    for path in (removed := [*damaged, *copies, *broken]):
        path.unlink()
    return removed


def _places(root: Path) -> tuple[Path, Path]:
    """Return where a repository has its cache, and what DVC has noted as in use."""
    from dvc.exceptions import DvcException
    from dvc.repo import Repo

    try:
        with Repo(str(root)) as repository:
            return Path(repository.cache.local.path), Path(repository.tmp_dir, "rwlock")
    except DvcException as error:
        raise InputError(root, f"is no repository that DVC can open: {error}") from None


def _whole(lock: Path) -> bool:
    """Whether DVC can read what it has noted as in use; nothing is noted without the file."""
    try:
        json.loads(lock.read_bytes())
    except FileNotFoundError:
        return True
    except ValueError:
        return False
    return True


def _cached(cache: Path) -> Iterator[tuple[Path, str]]:
    """Yield every file of a cache, stored as <2 digits>/<30 digits>, with its MD5."""
    for path in sorted(cache.glob("[0-9a-f][0-9a-f]/*")):
        if path.is_file():
            yield path, _digest(path)


def _named(path: Path) -> str:
    """Return the MD5 that a cached file's name promises; of a folder's list, ``.dir`` is added."""
    return path.parent.name + path.name.removesuffix(".dir")


def _outputs(root: Path) -> Iterator[Path]:
    """Yield every file among the outputs that DVC has noted."""
    lock = root / "dvc.lock"
    noted = stage_outputs(lock).values() if lock.exists() else []
    for path in sorted({root / output for outputs in noted for output in outputs}):
        yield from (file for file in [path, *path.rglob("*")] if file.is_file())


def _digest(path: Path) -> str:
    with path.open("rb") as content:
        return hashlib.file_digest(content, "md5").hexdigest()
