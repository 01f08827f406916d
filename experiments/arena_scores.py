"""Scores of verdicts on arenas, whose truth is known."""

from collections.abc import Iterator
from math import inf

import pandas as pd

# Whose errors are compared with the oracle's.
PREDICTORS = {
    "imperfect_c": "simulator C",
    "imperfect_c_with_net": "simulator C with a net",
    "transformer": "transformer",
    "hybrid": "hybrid",
    "amended": "simulator C, amended",
}
# The workflow's shots touch no racket; the position-dependent camera error is no single parameter.
NOT_SCORED = ("racket_bounce", "camera_distortion")
# Sizes of what is hidden, in minimum detectable effects.
CLASSES = {"below 1": (0.0, 1.0), "1 to 2": (1.0, 2.0), "2 to 4": (2.0, 4.0), "above 4": (4.0, inf)}
NET = "net"  # a class of its own: it has no such unit


def scored(causes: pd.DataFrame) -> pd.DataFrame:
    """Return the causes that count, with what is ``hidden``, ``named`` and ``covered``.

    Args:
        causes: of ``arena_result``, of any number of arenas.
    """
    rows = causes[~causes["effect"].isin(NOT_SCORED)]
    truth, original = rows["truth"].fillna(0.0), rows["original"].fillna(0.0)
    return rows.assign(
        hidden=truth != original,
        named=rows["low"].notna(),
        covered=(rows["low"] <= truth) & (truth <= rows["high"]),
        size=(truth - original).abs() / rows["detectable"],
    )


def found_by_size(causes: pd.DataFrame) -> Iterator[tuple[str, int, int]]:
    """Yield classes by size, how many hidden differences of each are named, and their number."""
    hidden = scored(causes).query("hidden")
    classes = {
        name: hidden[(low <= hidden["size"]) & (hidden["size"] < high)]
        for name, (low, high) in CLASSES.items()
    }
    is_net = hidden["effect"] == NET
    classes[NET] = hidden[is_net]
    other = hidden[hidden["size"].isna() & ~is_net]
    if len(other):
        classes["not identifiable"] = other
    for name, rows in classes.items():
        yield name, int(rows["named"].sum()), len(rows)


def ratios(errors: pd.DataFrame, predictor: str, horizon_ms: int) -> "pd.Series[float]":
    """Return the error of a predictor divided by that of the oracle, by arena."""
    at = errors[errors["horizon_ms"] == horizon_ms].set_index(["seed", "predictor"])["mean"]
    return at.xs(predictor, level=1) / at.xs("oracle", level=1)
