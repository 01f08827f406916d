"""What rallygap says on the terminal: always one line a problem, on stderr."""

import sys
from typing import NoReturn

from pipeline.errors import InputError


def refuse(error: InputError) -> NoReturn:
    """Print what is wrong with the input and end the process with status 2."""
    _print(str(error))
    sys.exit(2)


def warn(message: str) -> None:
    """Print what the user should know about a run that goes on."""
    _print(f"warning: {message}")


def _print(text: str) -> None:
    sys.stderr.writelines(f"rallygap: {line}\n" for line in text.splitlines())
