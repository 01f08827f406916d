"""A progress bar over phases of unequal length, with the time left; silent where nobody looks."""

from collections.abc import Iterator, Mapping
from contextlib import contextmanager

from rich.console import Console
from rich.progress import Progress, TaskID


class PhaseBar:
    """Draws on stderr how far the phases of one task have come."""

    def __init__(self, bar: Progress, task: TaskID, lengths: Mapping[str, float]) -> None:
        """Begin before the first phase.

        Args:
            bar: that is drawn.
            task: on it.
            lengths: of the phases, in any unit of time.
        """
        self._bar, self._task, self._lengths = bar, task, lengths
        self._begun = self._length = 0.0

    @contextmanager
    def phase(self, name: str) -> Iterator[None]:
        """Carry out the next phase."""
        self._length = self._lengths[name]
        self._bar.update(self._task, description=name)
        yield
        self._begun += self._length
        self._bar.update(self._task, completed=self._begun)

    def reached(self, share: float) -> None:
        """Draw that a share of the phase is done."""
        self._bar.update(self._task, completed=self._begun + share * self._length)

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
