"""Progress on the terminal, with the time left; silent where nobody looks."""

from collections.abc import Iterable, Sequence
from typing import TypeVar

from rich.console import Console
from rich.progress import track

Item = TypeVar("Item")


def progress(items: Sequence[Item], description: str) -> Iterable[Item]:
    """Yield the items and draw on stderr how far that has come."""
    console = Console(stderr=True)
    return track(items, description, console=console, disable=not console.is_terminal)
