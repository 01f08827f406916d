"""What rallygap says on the terminal: one line a problem, on stderr; tables without a gap."""

import sys
from typing import TYPE_CHECKING, NoReturn

from pipeline.runtime.errors import InputError

if TYPE_CHECKING:
    from rich.table import Table

WIDEST = 10_000  # characters of a table that no terminal shows


def refuse(error: InputError) -> NoReturn:
    """Print what is wrong with the input and end the process with status 2."""
    _print(str(error))
    sys.exit(2)


def warn(message: str) -> None:
    """Print what the user should know about a run that goes on."""
    _print(f"warning: {message}")


def show(table: "Table") -> None:
    """Print a table on stdout, in a file or a pipe as wide as it is: nobody sees what was cut."""
    from rich.console import Console

    console = Console()
    if not console.is_terminal:
        console.width = WIDEST
    console.print(table)


def _print(text: str) -> None:
    sys.stderr.writelines(f"rallygap: {line}\n" for line in text.splitlines())
