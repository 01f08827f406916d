"""Scores of verdicts on arenas, whose truth is known."""

from collections.abc import Iterator
from dataclasses import dataclass
from math import inf

import pandas as pd

# The workflow's shots touch no racket; the position-dependent camera error is no single parameter.
NOT_SCORED = ("racket_bounce", "camera_distortion")
# Sizes of what is hidden, in minimum detectable effects.
CLASSES = {"below 1": (0.0, 1.0), "1 to 2": (1.0, 2.0), "2 to 4": (2.0, 4.0), "above 4": (4.0, inf)}
NET = "net"  # a class of its own: it has no such unit
# Whose errors are compared with the oracle's.
PREDICTORS = {
    "imperfect_c": "simulator C",
    "imperfect_c_with_net": "simulator C with a net",
    "transformer": "transformer",
    "hybrid": "hybrid",
    "amended": "simulator C, amended",
}


@dataclass(frozen=True)
class Share:
    """A count, and what it is of."""

    count: int
    of: int


def scored(causes: pd.DataFrame) -> pd.DataFrame:
    """Return the causes that count, with what is ``hidden``, ``named`` and ``covered``.

    Args:
        causes: of ``arena_result``, of any number of arenas.
    """
    rows = causes[~causes["effect"].isin(NOT_SCORED)]
    truth, original = rows["truth"].fillna(0.0), rows["original"].fillna(0.0)
    sizes = (truth - original).abs() / rows["detectable"]
    return rows.assign(
        hidden=truth != original,
        named=rows["low"].notna(),
        covered=(rows["low"] <= truth) & (truth <= rows["high"]),
        size=sizes,
    )


def found_by_size(causes: pd.DataFrame) -> Iterator[tuple[str, Share]]:
    """Yield how many of the hidden differences are named, by their size."""
    hidden = scored(causes).query("hidden")
    for name, (low, high) in CLASSES.items():
        some = hidden[(low <= hidden["size"]) & (hidden["size"] < high)]
        yield name, _named(some)
    yield NET, _named(hidden[hidden["effect"] == NET])
    other = hidden[hidden["size"].isna() & (hidden["effect"] != NET)]
    if len(other):
        yield "not identifiable", _named(other)


def _named(rows: pd.DataFrame) -> Share:
    return Share(int(rows["named"].sum()), len(rows))


def made_up(causes: pd.DataFrame) -> Share:
    """Return how many of the named causes are not hidden."""
    named = scored(causes).query("named")
    return Share(int((~named["hidden"]).sum()), len(named))


def coverage(causes: pd.DataFrame) -> Share:
    """Return how many intervals of named causes contain the truth."""
    named = scored(causes).query("named")
    return Share(int(named["covered"].sum()), len(named))


def ratios(errors: pd.DataFrame, predictor: str, horizon_ms: int) -> "pd.Series[float]":
    """Return the error of a predictor divided by that of the oracle, by arena."""
    at = errors[errors["horizon_ms"] == horizon_ms].set_index(["seed", "predictor"])["mean"]
    found: pd.Series[float] = at.xs(predictor, level=1) / at.xs("oracle", level=1)
    return found


def gap_closed(errors: pd.DataFrame, horizon_ms: int) -> "pd.Series[float]":
    """Return the share of the removable error that amending takes away, by arena.

    What is removable is the error of simulator C, less that of the oracle.
    """
    before, after = (ratios(errors, name, horizon_ms) for name in ("imperfect_c", "amended"))
    return (before - after) / (before - 1.0)
