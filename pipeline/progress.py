"""Progress on the terminal, with the time left; silent where nobody looks."""

from collections.abc import Callable, Iterable, Iterator, Sequence
from contextlib import contextmanager
from typing import TypeVar

from rich.console import Console
from rich.progress import Progress, track

Item = TypeVar("Item")


def progress(items: Sequence[Item], description: str) -> Iterable[Item]:
    """Yield the items and draw on stderr how far that has come."""
    console = Console(stderr=True)
    return track(items, description, console=console, disable=not console.is_terminal)


@contextmanager
def progress_bar(description: str, total: int, done: int = 0) -> Iterator[Callable[[], None]]:
    """Yield a function that counts one item of ``total``, of which some may be ``done``."""
    console = Console(stderr=True)
    with Progress(console=console, disable=not console.is_terminal) as bar:
        task = bar.add_task(description, total=total, completed=done)
        yield lambda: bar.advance(task)
