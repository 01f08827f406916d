"""Numba compilation with a cache on disk that is never stale, and that all copies share.

Numba's cache checks the content of the function's file only, not functions and constants from
other files, and has a folder for every place where that file lies. Here the folder is named after
the content of all source files, so that another clone or environment does not compile again.
"""

import contextlib
import getpass
import hashlib
import os
import tempfile
from collections.abc import Callable, Iterable
from pathlib import Path
from typing import Any, TypeVar, cast

import numba
import platformdirs
from numba.core import config
from numba.core.caching import UserProvidedCacheLocator

Compiled = TypeVar("Compiled", bound=Callable[..., Any])


class SharedCache(UserProvidedCacheLocator):
    """Places binaries in ``numba.config.CACHE_DIR``, wherever the function's file lies."""

    @classmethod
    def get_suitable_cache_subpath(cls, py_file: str) -> str:
        """Return the folder of a file's functions; that of numba has the file's path."""
        return Path(py_file).parent.name


def compiler(sources: Iterable[Path], more: str = "") -> Callable[[Compiled], Compiled]:
    """Return a decorator for functions that depend only on ``sources`` and ``more``."""
    digest = hashlib.sha256(f"{numba.__version__} {more}".encode())
    for path in sources:
        digest.update(path.read_bytes())
    folder = _writable_cache() / digest.hexdigest()[:16]

    def compiled(function: Compiled) -> Compiled:
        options: Any = config  # numba fills this module at run time
        previous = options.CACHE_DIR, options.CACHE_LOCATOR_CLASSES
        options.CACHE_DIR = str(folder)
        options.CACHE_LOCATOR_CLASSES = f"{__name__}.{SharedCache.__name__}"
        try:
            return cast(Compiled, numba.njit(cache=True, error_model="numpy")(function))
        finally:
            options.CACHE_DIR, options.CACHE_LOCATOR_CLASSES = previous

    return compiled


def _writable_cache() -> Path:
    """Return the user's cache, or where the home cannot be written to a temporary one."""
    home = Path(platformdirs.user_cache_dir("rallygap"))
    with contextlib.suppress(OSError):
        home.mkdir(parents=True, exist_ok=True)
        if os.access(home, os.W_OK | os.X_OK):
            return home
    return Path(tempfile.gettempdir()) / f"rallygap-{getpass.getuser()}"
