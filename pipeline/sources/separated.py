"""Text of separated numbers: every line is a row of numbers, or refused with its reason."""

from collections.abc import Sequence

import numpy as np
import pandas as pd

from pipeline.runtime.errors import InputError
from pipeline.sources.files import SourceFile
from pipeline.sources.source import Refusal

NO_NUMBER = ["", "nan"]  # stated to be missing, unlike text that should not be there


def check_header(file: SourceFile, *headers: str) -> str:
    """Return the first line of ``file`` if it is one of ``headers``.

    Raises:
        InputError: it is another line.
    """
    lines = file.text().splitlines()
    if not lines:
        raise InputError(file.path, "is empty")
    found = ",".join(field.strip() for field in lines[0].split(","))
    if found not in headers:
        allowed = " or ".join(headers)
        raise InputError(file.path, f"the first line must be {allowed}, not {lines[0][:80]}", row=1)
    return found


def read_separated(
    file: SourceFile, columns: Sequence[str], *, separator: str, first_line: int = 1
) -> tuple[pd.DataFrame, list[Refusal]]:
    """Read rows of numbers; blank lines count for nothing.

    Args:
        file: the text.
        columns: names of the numbers in a line.
        separator: between two numbers.
        first_line: the 1-based line of the first row.

    Returns:
        Column ``row`` (1-based line) and ``columns``, with NaN for an empty field, and what is
        refused: lines of another length, and lines with text in them.

    Raises:
        InputError: the file is no text.
    """
    lines = enumerate(file.text().splitlines()[first_line - 1 :], start=first_line)
    fields = {row: line.split(separator) for row, line in lines if line.strip()}
    fitting = [row for row, found in fields.items() if len(found) == len(columns)]
    texts = pd.DataFrame([fields[row] for row in fitting], columns=list(columns), dtype=object)
    table, is_text = _numbers(texts)
    table.insert(0, "row", np.array(fitting, dtype=np.int64))
    misfits = sorted(fields.keys() - fitting)
    refusals = [Refusal(str(file), row, "wrong number of fields") for row in misfits]
    refusals += [Refusal(str(file), int(row), "not a number") for row in table["row"][is_text]]
    return table[~is_text].reset_index(drop=True), refusals


def _numbers(texts: pd.DataFrame) -> tuple[pd.DataFrame, pd.Series]:
    """Return the numbers (NaN where there is none) and which rows hold text instead."""
    stripped = texts.apply(lambda column: column.str.strip().str.lower())
    numbers = stripped.apply(pd.to_numeric, errors="coerce").astype(float)
    is_text = (numbers.isna() & ~stripped.isin(NO_NUMBER)).any(axis="columns")
    return numbers, is_text
