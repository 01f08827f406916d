"""Progress bars on stderr, with the time left; none where stderr is no terminal."""

from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from threading import Event, Thread
from typing import TypeVar

from rich.console import Console
from rich.progress import Progress, TaskID

Item = TypeVar("Item")

EVERY = 0.5  # s between two looks at what others do


def progress(items: Iterable[Item], description: str, total: int, done: int = 0) -> Iterator[Item]:
    """Yield the items and draw on stderr how far that has come.

    Args:
        items: those that are left to do.
        description: of the bar.
        total: number of items, with those that an earlier run has done.
        done: number of these.
    """
    console = Console(stderr=True)
    with Progress(console=console, disable=not console.is_terminal) as bar:
        task = bar.add_task(description, total=total, completed=done)
        for item in items:
            yield item
            bar.advance(task)


@contextmanager
def progress_bars(totals: Mapping[str, int], done: Callable[[], Sequence[int]]) -> Iterator[None]:
    """Draw on stderr how far others have come while the block runs, a bar each.

    Args:
        totals: of what each has to do, by its description.
        done: says how much of it each has done.
    """
    console, ended = Console(stderr=True), Event()
    with Progress(console=console, disable=not console.is_terminal) as bars:
        tasks = [bars.add_task(description, total=total) for description, total in totals.items()]

        def draw() -> None:
            for task, count in zip(tasks, done(), strict=True):
                bars.update(task, completed=count)

        def watch() -> None:
            while not ended.wait(EVERY):
                draw()

        watcher = Thread(target=watch, daemon=True)
        watcher.start()
        try:
            yield
        finally:
            ended.set()
            watcher.join()
            draw()


class PhaseBar:
    """A progress bar over phases of unequal length."""

    def __init__(self, bar: Progress, task: TaskID, lengths: Mapping[str, float]) -> None:
        """Start before the first phase.

        Args:
            bar: that is drawn.
            task: on it.
            lengths: of the phases, in any unit of time.
        """
        self._bar, self._task, self._lengths = bar, task, lengths
        self._done = self._length = 0.0

    @contextmanager
    def phase(self, name: str) -> Iterator[None]:
        """Carry out the next phase."""
        self._length = self._lengths[name]
        self._bar.update(self._task, description=name)
        yield
        self._done += self._length
        self._bar.update(self._task, completed=self._done)

    def reached(self, share: float) -> None:
        """Draw that a share of the phase is done."""
        self._bar.update(self._task, completed=self._done + share * self._length)

    @contextmanager
    def aside(self) -> Iterator[None]:
        """Take the bar away while something is printed."""
        self._bar.stop()
        yield
        self._bar.start()


@contextmanager
def phase_bar(lengths: Mapping[str, float]) -> Iterator[PhaseBar]:
    """Yield a bar over phases, gone when they are done.

    Args:
        lengths: of the phases, in any unit of time.
    """
    console = Console(stderr=True)
    with Progress(
        console=console, transient=True, redirect_stdout=False, disable=not console.is_terminal
    ) as bar:
        yield PhaseBar(bar, bar.add_task("", total=sum(lengths.values())), lengths)
