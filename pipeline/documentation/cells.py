"""Committed tables, and their values as they are written in the documentation."""

from pathlib import Path
from typing import Any

import pandas as pd

from rallygap.models.predictors.evaluation import SHOWN_HORIZONS_MS
from rallygap.pipeline.runtime.errors import InputError
from rallygap.pipeline.web.labels import PREDICTORS

NONE = "–"
ERRORS = ("before_mm", "after_mm", "floor_mm")
HORIZON_HEADS = [f"{horizon} ms" for horizon in SHOWN_HORIZONS_MS]


def read_report(root: Path, name: str, query: str = "") -> Any:
    """Read a CSV table under ``reports/``, or the rows that a query chooses.

    It is typed ``Any`` because the stubs of pandas make a union of every cell.

    Raises:
        InputError: there is none.
    """
    path = root / "reports" / name
    if not path.is_file():
        raise InputError(path, "is missing; run the stage that writes it")
    table = pd.read_csv(path)
    return table.query(query) if query else table


def before_after(row: Any, prefix: str = "", digits: int = 0) -> str:
    """Return errors before and after amending, and the floor, in mm; a dash for none.

    Args:
        row: with ``before_mm``, ``after_mm`` and ``floor_mm``.
        prefix: of these names.
        digits: after the point.
    """
    before, after, floor = (row[f"{prefix}{name}"] for name in ERRORS)
    if pd.isna(before):
        return NONE
    return f"{before:.{digits}f} → {after:.{digits}f} ({floor:.{digits}f})"


def predictor_name(name: str) -> str:
    """Return what a predictor is called in a table."""
    return PREDICTORS.get(name, name.replace("_", " "))


def number(value: float) -> str:
    """Return four significant digits of a number, a dash for none."""
    return f"{value:.4g}" if pd.notna(value) else NONE


def with_interval(value: float, low: float, high: float, form: str = ".0f") -> str:
    """Return a value with its interval in brackets, a dash for none."""
    if pd.isna(value):
        return NONE
    return f"{value:z{form}} ({low:z{form}} to {high:z{form}})"


def in_points(row: Any) -> str:
    """Return the difference of shares in a row in points, with its interval."""
    return with_interval(100 * row.difference, 100 * row.ci_low, 100 * row.ci_high)
