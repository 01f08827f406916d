"""Messages on the terminal: one line per problem, on stderr; tables on stdout."""

import sys
from typing import TYPE_CHECKING, NoReturn

from rallygap.pipeline.runtime.errors import InputError

if TYPE_CHECKING:
    from rich.table import Table

WIDEST = 10_000  # characters of a table outside of a terminal


def refuse(error: InputError) -> NoReturn:
    """Print an error in the input and end the process with status 2."""
    _print(str(error))
    sys.exit(2)


def warn(message: str) -> None:
    """Print a warning about a run that continues."""
    _print(f"warning: {message}")


def show(table: "Table") -> None:
    """Print a table on stdout; in a file or a pipe without a limit of its width."""
    from rich.console import Console

    console = Console()
    if not console.is_terminal:
        console.width = WIDEST
    console.print(table)


def _print(text: str) -> None:
    sys.stderr.writelines(f"rallygap: {line}\n" for line in text.splitlines())
