"""Pictures and tables of reports as HTML pages show them."""

import base64
import csv
import io
import math
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd
from PIL import Image

from rallygap.pipeline.runtime.errors import InputError
from rallygap.pipeline.web.report_items import ReportFigure

SHOWN_DIGITS = 4  # of the largest number of a column; the file has them all


@dataclass(frozen=True)
class Column:
    """A column of a table as text, one cell a row."""

    name: str
    is_number: bool
    cells: list[str]


def read_figure(path: Path) -> str:
    """Return a PNG file as a data URI.

    Raises:
        InputError: if the file is missing or is no PNG.
    """
    content = _read(path)
    if not content.startswith(b"\x89PNG\r\n\x1a\n"):
        raise InputError(path, "is not a PNG; run its stage again")
    return _data_uri(content)


def read_first_frame(path: Path) -> str:
    """Return the first picture of an animated PNG file as a data URI.

    Raises:
        InputError: if the file is missing or is no PNG.
    """
    still = io.BytesIO()
    try:
        with Image.open(io.BytesIO(_read(path)), formats=["PNG"]) as picture:
            picture.load()
            picture.save(still, "PNG")
    except (OSError, SyntaxError):
        raise InputError(path, "is not a PNG; run its stage again") from None
    return _data_uri(still.getvalue())


def read_columns(path: Path) -> list[Column]:
    """Return the columns of a CSV file, numbers rounded to the digits worth reading.

    Raises:
        InputError: if the file is missing, is no CSV table or has a number that is not finite.
    """
    return [
        Column(str(name), str(values.dtype) in ("Int64", "Float64"), _cells(values))
        for name, values in read_rows(path).items()
    ]


def read_rows(path: Path) -> pd.DataFrame:
    """Return a CSV file as a table; what is not there is null.

    Raises:
        InputError: as ``read_columns``.
    """
    _read(path)
    try:
        with path.open(encoding="utf-8", newline="") as file:
            widths = {len(row) for row in csv.reader(file) if row}
        if len(widths) > 1:  # pandas would take what is too many for an index
            raise ValueError("rows are longer or shorter than others")
        table = pd.read_csv(
            path, dtype_backend="numpy_nullable", keep_default_na=False, na_values=[""]
        )
        for name, values in table.select_dtypes("Float64").items():
            if np.isinf(values.to_numpy(float, na_value=0.0)).any():
                raise ValueError(f"{name} has a number that is not finite")
    except (ValueError, csv.Error) as error:
        raise InputError(path, f"is not a CSV table: {error}; run its stage again") from None
    return table


def _data_uri(png: bytes) -> str:
    return f"data:image/png;base64,{base64.b64encode(png).decode()}"


def _read(path: Path) -> bytes:
    try:
        return path.read_bytes()
    except OSError:
        raise InputError(path, "cannot be read; run its stage again") from None


def _cells(values: pd.Series) -> list[str]:
    if not pd.api.types.is_float_dtype(values):
        return ["–" if pd.isna(value) else str(value) for value in values]
    largest = values.abs().max()
    magnitude = 0 if pd.isna(largest) or largest == 0 else math.floor(math.log10(largest))
    decimals = min(max(SHOWN_DIGITS - 1 - magnitude, 0), 8)
    return ["–" if pd.isna(value) else _rounded(value, decimals) for value in values]


def _rounded(value: float, decimals: int) -> str:
    """Return a number with so many decimals; one that would vanish keeps two digits."""
    return f"{value:.2g}" if 0 < abs(value) < 0.5 * 10**-decimals else f"{value:.{decimals}f}"


def shown_figure(figure: ReportFigure, folder: Path) -> dict[str, str]:
    """Return a figure that was written to a folder, with the picture inside.

    Raises:
        InputError: it was not.
    """
    source = read_figure(folder / f"{figure.name}.png")
    return {"title": figure.title, "caption": figure.caption, "source": source}


def page_table(columns: dict[str, list[str]]) -> dict[str, Any]:
    """Return columns as a table; a trailing blank in a name marks numbers."""
    shown = [
        Column(name.strip(), is_number=name.endswith(" "), cells=cells)
        for name, cells in columns.items()
    ]
    return {"columns": shown, "rows": range(len(shown[0].cells))}
