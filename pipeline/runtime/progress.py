"""Progress bars on stderr, with the time left; none where stderr is no terminal."""

from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from typing import TypeVar

from rich.console import Console, RenderableType
from rich.progress import Progress

Item = TypeVar("Item")


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


class WatchedBars(Progress):
    """Bars on stderr of what others do; asks how far that has come whenever it draws.

    Args:
        totals: of what each has to do, by its description.
        done: says how much of it each has done.
    """

    def __init__(self, totals: Mapping[str, int], done: Callable[[], Sequence[int]]) -> None:
        console, self._done = Console(stderr=True), done
        super().__init__(console=console, disable=not console.is_terminal)
        for description, total in totals.items():
            self.add_task(description, total=total)

    def get_renderables(self) -> Iterable[RenderableType]:
        """Return the bars as they are now."""
        for task, count in zip(self.task_ids, self._done(), strict=False):  # rich draws none first
            self.update(task, completed=count)
        return super().get_renderables()


class PhaseBar(Progress):
    """A bar on stderr over phases of unequal length, gone when they are done.

    Args:
        lengths: of the phases, in any unit of time.
    """

    def __init__(self, lengths: Mapping[str, float]) -> None:
        console = Console(stderr=True)
        hidden = not console.is_terminal
        super().__init__(console=console, transient=True, redirect_stdout=False, disable=hidden)
        self._bar = self.add_task("", total=sum(lengths.values()))
        self._lengths, self._before, self._length = lengths, 0.0, 0.0

    @contextmanager
    def phase(self, name: str) -> Iterator[None]:
        """Carry out the next phase."""
        self._length = self._lengths[name]
        self.update(self._bar, description=name)
        yield
        self.reached(1.0)
        self._before += self._length

    def reached(self, share: float) -> None:
        """Draw that a share of the phase is done."""
        self.update(self._bar, completed=self._before + share * self._length)

    @contextmanager
    def aside(self) -> Iterator[None]:
        """Take the bar away while something is printed."""
        self.stop()
        yield
        self.start()
