"""Rows that are physically impossible are refused, each with its reason."""

from collections.abc import Sequence
from typing import Literal

import numpy as np
import pandas as pd

from rallygap.pipeline.io.frame import Frame
from rallygap.pipeline.io.schemas import (
    FARTHEST_POSITION,
    FASTEST_BALL,
    FASTEST_SPIN,
    POSITION_COLUMNS,
    SPIN_COLUMNS,
    STATE_COLUMNS,
    VELOCITY_COLUMNS,
)
from rallygap.pipeline.sources.source import RawTable, Refusal

SAMPLE_COLUMNS = ["t", *POSITION_COLUMNS, *SPIN_COLUMNS]
LAUNCH_COLUMNS = ["id", *STATE_COLUMNS]
SHORTEST_STEP = 1e-6  # s, between two samples
ONLY_SAMPLE = "the only sample of its recording"


class RowChecks:
    """Rows and labels of some tables, of which checks refuse the impossible ones.

    Attributes:
        rows: not refused so far, of all tables in their order; column ``table`` is the number of
            the table.
        refusals: by checks and by the reader.
    """

    def __init__(self, tables: Sequence[RawTable], columns: list[str]) -> None:
        self._places = [table.place for table in tables]
        self.refusals = [refusal for table in tables for refusal in table.refusals]
        rows = pd.concat([table.rows for table in tables], ignore_index=True)
        numbers = dict.fromkeys([name for name in columns if name != "id"], float)
        self.rows = rows.reindex(columns=["row", *columns]).astype(numbers)
        lengths = [len(table.rows) for table in tables]
        self.rows.insert(0, "table", np.repeat(np.arange(len(tables)), lengths))

    def refuse_rows(self, reason: str, at_fault: "pd.Series[bool]") -> None:
        """Remove rows."""
        self._refuse(at_fault, reason, "row")
        self.rows = self.rows[~at_fault]

    def refuse_labels(self, reason: str, at_fault: "pd.Series[bool]") -> None:
        """Remove the spin of rows."""
        self._refuse(at_fault, reason, "label")
        self.rows.loc[at_fault, SPIN_COLUMNS] = np.nan

    def _refuse(
        self, at_fault: "pd.Series[bool]", reason: str, what: Literal["row", "label"]
    ) -> None:
        faulty = self.rows[at_fault]
        for table, row in zip(faulty["table"], faulty["row"], strict=True):
            self.refusals.append(Refusal(self._places[table], int(row), reason, what))

    def longer(self, columns: list[str], limit: float) -> "pd.Series[bool]":
        """Return the rows in which the vector in ``columns`` is longer than ``limit``."""
        with np.errstate(over="ignore"):  # an overflow is too long, too
            length = np.linalg.norm(self.rows[columns].to_numpy(dtype=float), axis=1)
        return pd.Series(length > limit, index=self.rows.index)


def check_samples(tables: Sequence[RawTable], frame: Frame) -> RowChecks:
    """Transform recordings into the table frame and refuse impossible samples and labels."""
    checks = RowChecks(tables, SAMPLE_COLUMNS)
    _check_numbers(checks, ["t", *POSITION_COLUMNS])
    _check_labels(checks)
    _check_positions(checks, frame)
    _check_times(checks)
    samples = checks.rows.groupby("table")["t"].transform("size")
    checks.refuse_rows(ONLY_SAMPLE, samples == 1)
    return checks


def check_launches(tables: Sequence[RawTable], frame: Frame) -> RowChecks:
    """Transform launches into the table frame and refuse impossible states and labels."""
    checks = RowChecks(tables, LAUNCH_COLUMNS)
    _check_numbers(checks, [*POSITION_COLUMNS, *VELOCITY_COLUMNS])
    _check_labels(checks)
    _check_positions(checks, frame)
    too_fast = checks.longer(VELOCITY_COLUMNS, FASTEST_BALL)
    checks.refuse_rows(f"faster than {FASTEST_BALL:g} m/s", too_fast)
    checks.refuse_rows("id repeated", checks.rows.duplicated(["table", "id"]))
    return checks


def _check_numbers(checks: RowChecks, columns: list[str]) -> None:
    finite = np.isfinite(checks.rows[columns].to_numpy(dtype=float)).all(axis=1)
    checks.refuse_rows("not a number", pd.Series(~finite, index=checks.rows.index))


def _check_labels(checks: RowChecks) -> None:
    known = checks.rows[SPIN_COLUMNS].notna()
    checks.refuse_labels("spin incomplete", known.any(axis=1) & ~known.all(axis=1))
    too_fast = checks.longer(SPIN_COLUMNS, FASTEST_SPIN)
    checks.refuse_labels(f"spin above {FASTEST_SPIN:g} rad/s", too_fast)


def _check_positions(checks: RowChecks, frame: Frame) -> None:
    checks.rows = frame.to_table(checks.rows)
    far = (checks.rows[POSITION_COLUMNS].abs() > FARTHEST_POSITION).any(axis=1)
    checks.refuse_rows(f"farther than {FARTHEST_POSITION:g} m", far)


def _check_times(checks: RowChecks) -> None:
    """Refuse samples that are not later than every previous sample of their recording."""
    latest = checks.rows.groupby("table")["t"].cummax()
    step = checks.rows["t"] - latest.groupby(checks.rows["table"]).shift()
    checks.refuse_rows("time backwards", step < 0)
    checks.refuse_rows("time repeated", step[checks.rows.index] < SHORTEST_STEP)
