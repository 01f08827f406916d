"""The error of a user's input: where it is, what is wrong, what to do."""

import copyreg
from pathlib import Path
from typing import Any

LONGEST = 500  # characters of a problem or a field: what is wrong with a file may quote all of it


class InputError(Exception):
    """Input that cannot be used. The command line prints it as one line, without a traceback.

    Args:
        where: the file, folder or parameter at fault.
        problem: what is wrong with it and what to do, as the end of a sentence.
        row: 1-based line or row in the file, where known.
        field: column, key or data set in the file, where known.
    """

    def __init__(
        self, where: Path | str, problem: str, *, row: int | None = None, field: str | None = None
    ) -> None:
        self.where, self.row = str(where), row
        self.problem = _shortened(problem)
        self.field = _shortened(field) if field else None
        place = self.where
        if row is not None:
            place += f", row {row}"
        if self.field is not None:
            place += f", {self.field}"
        super().__init__(f"{place}: {self.problem}")

    def __reduce__(self) -> tuple[Any, ...]:
        """Pickle it, so that a worker process can raise it."""
        return copyreg.__newobj__, (type(self), *self.args), self.__dict__  # type: ignore[attr-defined]


def _shortened(text: str) -> str:
    return text if len(text) <= LONGEST else f"{text[:LONGEST]}…"
