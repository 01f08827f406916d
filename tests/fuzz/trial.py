"""What is wrong with how a reader takes a file. Time and memory are bounded."""

import faulthandler
import resource
import signal
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from rallygap.pipeline.runtime.errors import InputError
from tests.fuzz.hostile import SENTINEL
from tests.fuzz.readers import Reader

LONGEST = 20  # s of the processor
LONGEST_WAIT = 300  # s on the clock, after which nothing but the end of the campaign helps
LARGEST = 400_000  # kB that one input may take
ADDRESSES = 8 * 2**30  # bytes that a campaign may ask for beyond what it began with
LONGEST_LINE = 1500  # characters of a refusal that can be read
MOST_SHOWN = 400  # characters of a fault


class TooLong(BaseException):
    """A reader works for too long; no error, so that no reader takes it for one of its file's."""


def fault(reader: Reader, folder: Path, path: Path) -> str | None:
    """Return what is wrong with one reading; None where the file is read, or clearly refused."""
    Path("/proc/self/clear_refs").write_text("5")  # resets the peak
    before = _memory("VmRSS")
    SENTINEL.unlink(missing_ok=True)
    wrong = None
    try:
        with limited_time():
            reader.read(folder)
    except InputError as error:
        wrong = _unclear(str(error), folder, path)
    except (Exception, TooLong) as error:
        wrong = f"{type(error).__name__}: {error}"[:MOST_SHOWN]
    taken = _memory("VmHWM") - before
    if taken > LARGEST:
        return f"took {taken // 1000} MB"
    return "ran code" if SENTINEL.exists() else wrong


def _unclear(message: str, folder: Path, path: Path) -> str | None:
    """A refusal must name the file, or its source, and can be read."""
    names = {path.name, path.parent.name, folder.name}
    lines = message.splitlines()
    if not any(name in lines[0] for name in names):
        return f"names no file: {message[:MOST_SHOWN]}"
    if max(map(len, lines)) > LONGEST_LINE:
        return f"no line to be read: {message[:MOST_SHOWN]}"
    return None


def _memory(name: str) -> int:
    """A number of /proc/self/status, kB."""
    lines = Path("/proc/self/status").read_text().splitlines()
    (line,) = (line for line in lines if line.startswith(f"{name}:"))
    return int(line.split()[1])


@contextmanager
def limited_time() -> Iterator[None]:
    """Raise where the processor works for too long, and end it all where nothing comes back."""

    def stop(*_: object) -> None:
        raise TooLong(f"still reading after {LONGEST} s")

    former = signal.signal(signal.SIGPROF, stop)
    signal.setitimer(signal.ITIMER_PROF, LONGEST)
    faulthandler.dump_traceback_later(LONGEST_WAIT, exit=True)
    try:
        yield
    finally:
        faulthandler.cancel_dump_traceback_later()
        signal.setitimer(signal.ITIMER_PROF, 0)
        signal.signal(signal.SIGPROF, former)


@contextmanager
def limited_memory() -> Iterator[None]:
    """Let no input take the machine's memory."""
    former = resource.getrlimit(resource.RLIMIT_AS)
    used = int(Path("/proc/self/statm").read_text().split()[0]) * resource.getpagesize()
    resource.setrlimit(resource.RLIMIT_AS, (used + ADDRESSES, former[1]))
    try:
        yield
    finally:
        resource.setrlimit(resource.RLIMIT_AS, former)
