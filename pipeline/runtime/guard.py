"""One run of a stage at a time, a clean end on SIGTERM, one line for a full disk."""

import errno
import signal
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from types import FrameType
from typing import Any, NoReturn

from filelock import FileLock, Timeout

from rallygap.pipeline.runtime.console import warn
from rallygap.pipeline.runtime.errors import InputError

ADVICE = {
    errno.ENOSPC: "the disk is full; make room and run it again",
    errno.EDQUOT: "the quota of the disk is used up; make room and run it again",
    errno.EROFS: "the disk can only be read; mount it for writing and run it again",
    errno.EACCES: "this user may not write there",
}


@contextmanager
def guarded(stage: str) -> Iterator[None]:
    """Run a stage in the working directory within this block.

    Another run of it is waited for, such as one whose DVC process was killed: it would remove
    outputs and checkpoints of this one when it ends. SIGTERM unwinds the block, so that no partial
    output and no worker remains.
    """
    lock = FileLock(Path("scratch") / f"{stage}.lock")
    with disks_named(stage):
        Path("scratch").mkdir(exist_ok=True)
        try:
            lock.acquire(timeout=0)
        except Timeout:
            warn(f"another run of {stage} is at work here; this one waits until it has ended")
            lock.acquire()
        before: Any = signal.signal(signal.SIGTERM, _stop)
        try:
            yield
        finally:
            signal.signal(signal.SIGTERM, before)
            lock.release()


def _stop(number: int, _: FrameType | None) -> NoReturn:
    raise SystemExit(128 + number)


@contextmanager
def disks_named(otherwise: str) -> Iterator[None]:
    """Turn an error of the disk into one line.

    Args:
        otherwise: start of the line where the error names no file.
    """
    try:
        yield
    except OSError as error:
        if error.errno not in ADVICE:
            raise
        raise InputError(error.filename or otherwise, ADVICE[error.errno]) from None
