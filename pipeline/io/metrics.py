"""Metrics: numbers under what they belong to, as a report's metrics.json keeps them."""

from collections.abc import Hashable, Iterable, Sequence
from typing import Any

import numpy as np
import pandas as pd


def rounded(value: float, digits: int = 6) -> float:
    """Return six digits: more would only show the processor's last bits."""
    return float(f"{value:.{digits}g}")


def place(metrics: dict[str, Any], keys: Iterable[Hashable]) -> dict[str, Any]:
    """Return the metrics under ``keys``, one within the other; what is not there yet is made."""
    for key in keys:
        metrics = metrics.setdefault(str(key), {})
    return metrics


def nested(table: pd.DataFrame, keys: Sequence[str]) -> dict[str, Any]:
    """Return ``{key: {...: {column: value}}}``; values that are not finite are left out.

    Args:
        table: one row for each combination of keys; all other columns are numbers.
        keys: columns, the outermost first.
    """
    metrics: dict[str, Any] = {}
    for row in table.to_dict("records"):
        values = {str(name): value for name, value in row.items() if name not in keys}
        finite = {name: rounded(value) for name, value in values.items() if np.isfinite(value)}
        place(metrics, [row[key] for key in keys]).update(finite)
    return metrics
