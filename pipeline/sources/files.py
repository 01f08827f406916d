"""Files of a source: found in a fixed order; text of separated numbers, one row per line."""

from collections.abc import Sequence
from pathlib import Path

import numpy as np
import pandas as pd

from rallygap.pipeline.runtime.errors import InputError
from rallygap.pipeline.sources.source import Refusal

MISSING = ["", "nan"]  # fields that state a missing number, unlike other text


def source_file(folder: Path, name: str) -> Path:
    """Return the path of a file that the source needs.

    Raises:
        InputError: there is no such file.
    """
    if not (folder / name).is_file():
        raise InputError(folder / name, "there is no such file, and the source needs it")
    return folder / name


def source_files(folder: Path, pattern: str) -> list[Path]:
    """Return the files of a source whose names match ``pattern``, sorted by name.

    Raises:
        InputError: there is none, or a name cannot be part of a recording's id.
    """
    paths = sorted(
        path for path in folder.glob(pattern) if path.is_file() and not path.name.startswith(".")
    )
    if not paths:
        raise InputError(folder, f"holds no file {pattern}")
    for path in paths:
        if not path.name.isprintable():
            raise InputError(folder, f"file name {path.name!a} has unprintable characters")
    return paths


def read_text(path: Path) -> str:
    """Return the content as UTF-8 text without a byte order mark.

    Raises:
        InputError: the file cannot be read, or is no text.
    """
    try:
        return path.read_text(encoding="utf-8-sig")
    except UnicodeDecodeError:
        raise InputError(path, "is not UTF-8 text; is it what its name says?") from None
    except OSError as error:
        raise InputError(path, f"cannot be read: {error.strerror}") from None


def check_header(path: Path, *headers: str) -> str:
    """Return the first line of a file if it is one of ``headers``.

    Raises:
        InputError: it is another line.
    """
    lines = read_text(path).splitlines()
    if not lines:
        raise InputError(path, "is empty")
    header = ",".join(field.strip() for field in lines[0].split(","))
    if header not in headers:
        allowed = " or ".join(headers)
        raise InputError(path, f"the first line must be {allowed}, not {lines[0][:80]}", row=1)
    return header


def read_separated(
    path: Path, columns: Sequence[str], *, separator: str, first_line: int = 1
) -> tuple[pd.DataFrame, list[Refusal]]:
    """Read rows of numbers; blank lines are skipped.

    Args:
        path: of the text.
        columns: names of the numbers in a line.
        separator: between two numbers.
        first_line: the 1-based line of the first row.

    Returns:
        Column ``row`` (1-based line) and ``columns``, with NaN for an empty field, and the refused
        lines: those of another length, and those with text.

    Raises:
        InputError: the file is no text.
    """
    lines = enumerate(read_text(path).splitlines()[first_line - 1 :], start=first_line)
    fields = {row: line.split(separator) for row, line in lines if line.strip()}
    complete = [row for row, values in fields.items() if len(values) == len(columns)]
    texts = pd.DataFrame([fields[row] for row in complete], columns=list(columns), dtype=object)
    texts = texts.apply(lambda column: column.str.strip().str.lower())
    table = texts.apply(pd.to_numeric, errors="coerce").astype(float)
    is_text = (table.isna() & ~texts.isin(MISSING)).any(axis="columns")
    table.insert(0, "row", np.array(complete, dtype=np.int64))
    others = sorted(fields.keys() - complete)
    refusals = [Refusal(path.name, row, "wrong number of fields") for row in others]
    refusals += [Refusal(path.name, int(row), "not a number") for row in table["row"][is_text]]
    return table[~is_text].reset_index(drop=True), refusals
