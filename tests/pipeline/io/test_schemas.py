"""Contracts: good tables pass as they are, broken ones are named with row and column."""

import numpy as np
import pandas as pd
import pytest

from rallygap.pipeline.io.artifacts import write_table
from rallygap.pipeline.io.schemas import (
    CONTACTS,
    EPISODES,
    LAUNCHES,
    POINTS,
    RECORDINGS,
    SAMPLES,
    TRUE_CONTACTS,
    checked,
    empty,
    read_checked,
)
from rallygap.pipeline.runtime.errors import InputError


def good(contract, **changes):
    """Three rows that keep a contract, of one recording."""
    values = {}
    for name, column in contract.columns.items():
        choices = [check.statistics for check in column.checks if check.name == "isin"]
        if column.unique:
            values[name] = ["a", "b", "c"]
        elif choices:
            values[name] = [choices[0]["allowed_values"][0]] * 3
        else:
            values[name] = pd.Series([1, 1, 1]).astype(column.dtype.type)
    times = {"t": [0.0, 0.1, 0.2], "start": [0.0, 2.0, 4.0], "end": [1.0, 3.0, 5.0]}
    values |= {name: time for name, time in times.items() if name in values}
    return pd.DataFrame({**values, **changes})


CONTRACTS = [RECORDINGS, LAUNCHES, POINTS, TRUE_CONTACTS, SAMPLES, CONTACTS, EPISODES]
each = pytest.mark.parametrize("contract", CONTRACTS, ids=lambda contract: contract.name)


@each
def test_a_good_table_passes_unchanged_and_through_a_file(tmp_path, contract):
    table = good(contract)
    write_table(tmp_path / "table.parquet", table)
    read = read_checked(tmp_path / "table.parquet", contract)
    pd.testing.assert_frame_equal(read, checked(table, contract))
    pd.testing.assert_frame_equal(read, table)
    assert checked(table.iloc[:0], contract).empty
    pd.testing.assert_frame_equal(checked(empty(contract), contract), table.iloc[:0])


@each
def test_a_file_at_fault_is_named_with_the_column(tmp_path, contract):
    path = tmp_path / "table.parquet"
    table = good(contract)
    last = table.columns[-1]
    for broken, place in (
        (table.drop(columns=last), f"{last}: is missing; run the stage"),
        (table.assign(extra=1), "extra: is no column of this table; run the stage"),
        (table.assign(**{last: [[1]] * len(table)}), last),
    ):
        write_table(path, broken)
        with pytest.raises(InputError, match=rf"table\.parquet, .*{place}"):
            read_checked(path, contract)


@pytest.mark.parametrize(
    ("contract", "changes", "problem"),
    [
        (RECORDINGS, {"px": [0.0, 20.1, 0.0]}, "row 2, px: breaks in_range"),
        (RECORDINGS, {"px": [0.0, 0.0, np.nan]}, "row 3, px: breaks not_nullable"),
        (RECORDINGS, {"px": ["0", "0", "0"]}, "px: breaks dtype"),
        (RECORDINGS, {"t": [0.0, 0.1, np.inf]}, "row 3, t: breaks must be finite"),
        (RECORDINGS, {"t": [0.0, 0.1, 0.1]}, ": time must grow within every recording"),
        (LAUNCHES, {"launch_id": ["a", "b", "a"]}, "row [13], launch_id"),
        (POINTS, {"end": [1.0, 2.0, 5.0]}, "end must be after start"),
        (POINTS, {"winner": ["far", "me", "far"]}, "row 2, winner: breaks isin"),
        (TRUE_CONTACTS, {"t": [0.0, 0.2, 0.1]}, ": time must not go back"),
        (TRUE_CONTACTS, {"wx": [0.0, np.nan, 0.0]}, "row 2, wx: breaks not_nullable"),
        (EPISODES, {"split": ["train", "test", "train"]}, ": every recording must be in one"),
    ],
)
def test_what_cannot_be_is_named_with_its_place(contract, changes, problem):
    with pytest.raises(InputError, match=f"table of {contract.name}.*{problem}"):
        checked(good(contract, **changes), contract)


def test_a_displaced_column_is_named_and_what_may_be_passes():
    with pytest.raises(InputError, match=r"table of launches, .*is out of order"):
        checked(good(LAUNCHES).iloc[:, ::-1], LAUNCHES)
    table = good(RECORDINGS, recording_id=["a", "a", "b"], t=[0.0, 0.1, 0.0], wx=np.nan)
    assert checked(table, RECORDINGS)["t"].tolist() == [0.0, 0.1, 0.0]
    checked(good(TRUE_CONTACTS, t=[0.0, 0.1, 0.1]), TRUE_CONTACTS)
