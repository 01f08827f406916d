"""Rows that no measured ball can have made are refused, each with its reason."""

from collections.abc import Sequence
from typing import Literal

import numpy as np
import pandas as pd

from pipeline.io.schemas import (
    FARTHEST_POSITION,
    FASTEST_BALL,
    FASTEST_SPIN,
    POSITION_COLUMNS,
    SPIN_COLUMNS,
    STATE_COLUMNS,
    VELOCITY_COLUMNS,
)
from pipeline.sources.frame import Frame
from pipeline.sources.source import RawTable, Refusal

SAMPLE_COLUMNS = ["t", *POSITION_COLUMNS, *SPIN_COLUMNS]
LAUNCH_COLUMNS = ["id", *STATE_COLUMNS]
SHORTEST_STEP = 1e-6  # s; no camera takes two pictures within it
ONLY_SAMPLE = "the only sample of its recording"  # which makes no path


class Sieve:
    """Holds back rows and labels that cannot be; what passes is in ``rows``.

    Attributes:
        rows: of all tables, in their order; column ``table`` is the table's place among them.
        refusals: what was held back, and what the reader could not make out.
    """

    def __init__(self, tables: Sequence[RawTable], columns: list[str]) -> None:
        self._places = [table.place for table in tables]
        self.refusals = [refusal for table in tables for refusal in table.refusals]
        rows = pd.concat([table.rows for table in tables], ignore_index=True)
        numbers = dict.fromkeys([name for name in columns if name != "id"], float)
        self.rows = rows.reindex(columns=["row", *columns]).astype(numbers)
        lengths = [len(table.rows) for table in tables]
        self.rows.insert(0, "table", np.repeat(np.arange(len(tables)), lengths))

    def refuse(self, reason: str, at_fault: "pd.Series[bool]") -> None:
        """Leave out the rows at fault."""
        self._note(at_fault, reason, "row")
        self.rows = self.rows[~at_fault]

    def unlabel(self, reason: str, at_fault: "pd.Series[bool]") -> None:
        """Keep the rows at fault, without their spin."""
        self._note(at_fault, reason, "label")
        self.rows.loc[at_fault, SPIN_COLUMNS] = np.nan

    def _note(
        self, at_fault: "pd.Series[bool]", reason: str, what: Literal["row", "label"]
    ) -> None:
        faulty = self.rows[at_fault]
        for table, row in zip(faulty["table"], faulty["row"], strict=True):
            self.refusals.append(Refusal(self._places[table], int(row), reason, what))


def sift_samples(tables: Sequence[RawTable], frame: Frame) -> Sieve:
    """Move recordings into the table frame and hold back what is impossible."""
    sieve = Sieve(tables, SAMPLE_COLUMNS)
    _sift_numbers(sieve, ["t", *POSITION_COLUMNS])
    _sift_labels(sieve)
    _sift_positions(sieve, frame)
    _sift_times(sieve)
    samples = sieve.rows.groupby("table")["t"].transform("size")
    sieve.refuse(ONLY_SAMPLE, samples == 1)
    return sieve


def sift_launches(tables: Sequence[RawTable], frame: Frame) -> Sieve:
    """Move launches into the table frame and hold back what is impossible."""
    sieve = Sieve(tables, LAUNCH_COLUMNS)
    _sift_numbers(sieve, [*POSITION_COLUMNS, *VELOCITY_COLUMNS])
    _sift_labels(sieve)
    _sift_positions(sieve, frame)
    sieve.refuse(
        f"faster than {FASTEST_BALL:g} m/s", _longer(sieve, VELOCITY_COLUMNS, FASTEST_BALL)
    )
    sieve.refuse("id repeated", sieve.rows.duplicated(["table", "id"]))
    return sieve


def _sift_numbers(sieve: Sieve, columns: list[str]) -> None:
    finite = np.isfinite(sieve.rows[columns].to_numpy(dtype=float)).all(axis=1)
    sieve.refuse("not a number", pd.Series(~finite, index=sieve.rows.index))


def _sift_labels(sieve: Sieve) -> None:
    known = sieve.rows[SPIN_COLUMNS].notna()
    sieve.unlabel("spin incomplete", known.any(axis=1) & ~known.all(axis=1))
    too_fast = _longer(sieve, SPIN_COLUMNS, FASTEST_SPIN)
    sieve.unlabel(f"spin above {FASTEST_SPIN:g} rad/s", too_fast)


def _sift_positions(sieve: Sieve, frame: Frame) -> None:
    sieve.rows = frame.to_table(sieve.rows)
    far = (sieve.rows[POSITION_COLUMNS].abs() > FARTHEST_POSITION).any(axis=1)
    sieve.refuse(f"farther than {FARTHEST_POSITION:g} m", far)


def _sift_times(sieve: Sieve) -> None:
    """Refuse samples that are not later than every sample of their recording before them."""
    latest = sieve.rows.groupby("table")["t"].cummax()
    step = sieve.rows["t"] - latest.groupby(sieve.rows["table"]).shift()
    sieve.refuse("time backwards", step < 0)
    sieve.refuse("time repeated", step[sieve.rows.index] < SHORTEST_STEP)


def _longer(sieve: Sieve, columns: list[str], limit: float) -> "pd.Series[bool]":
    """Return where the vector in ``columns`` is longer than ``limit``."""
    with np.errstate(over="ignore"):  # too long for a float is too long
        length = np.linalg.norm(sieve.rows[columns].to_numpy(dtype=float), axis=1)
    return pd.Series(length > limit, index=sieve.rows.index)
