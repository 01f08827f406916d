"""An invalid file of forecasts is one error that names the place."""

import re

import numpy as np
import pandas as pd
import pyarrow as pa
import pyarrow.parquet as pq
import pytest

from rallygap.pipeline.benchmark.forecasts import read_forecasts
from rallygap.pipeline.benchmark.windows import window_table
from rallygap.pipeline.runtime.errors import InputError
from tests.pipeline.benchmark.forecasting import ZeroPredictor, forecasts_of


@pytest.fixture
def forecasts(sets):
    """A whole table of forecasts, in the order of the windows' names."""
    return forecasts_of(ZeroPredictor(), window_table(sets))


def refusal(path, forecasts, sets):
    forecasts.to_parquet(path, index=False)
    with pytest.raises(InputError) as refused:
        read_forecasts(path, sets)
    assert "\n" not in str(refused.value)
    return str(refused.value).removeprefix(str(path))


@pytest.mark.parametrize(
    ("column", "value", "problem"),
    [
        ("window_id", "ffff", r"window_id: ffff is no window of this run; run `"),
        ("px", np.nan, "px: breaks not_nullable"),
        ("vy", np.inf, "vy: breaks in_range"),
        ("wz", 1e300, "wz: breaks in_range"),
        ("horizon_ms", 101, "horizon_ms: breaks isin"),
        ("horizon_ms", 125, r"window_id: \w{16} has this horizon twice; keep one row"),
    ],
)
def test_an_invalid_row_is_named_with_its_field(tmp_path, sets, forecasts, column, value, problem):
    forecasts.loc[6, column] = value
    assert re.match(f", row 7, {problem}", refusal(tmp_path / "f.parquet", forecasts, sets))


@pytest.mark.parametrize(
    ("changed", "expected"),
    [
        (lambda table: table.drop(columns="vz"), ", vz: is missing"),
        (lambda table: table.assign(note="mine"), ", note: is no column of forecasts"),
        (lambda table: table.assign(px="far"), ", px: has the type large_string; give float64"),
        (lambda table: table.assign(horizon_ms=0.1), ", horizon_ms: has the type double; give int"),
        (lambda table: table.assign(window_id=7), ", window_id: has the type int64; give string"),
        (lambda table: table.iloc[:0], ": has no row"),
        (lambda table: table.iloc[1:], ": window {name} has no row for 100 ms, and 0 more"),
        (lambda table: table.iloc[41:], ": window {name} has no row for 100 ms, and 40 more"),
        (lambda table: pd.concat([table, table]), ": has {twice} rows; all windows have {rows}"),
    ],
)
def test_a_table_of_another_shape_is_refused(tmp_path, sets, forecasts, changed, expected):
    rows, name = len(forecasts), forecasts["window_id"].iloc[0]
    expected = expected.format(name=name, rows=rows, twice=2 * rows)
    assert refusal(tmp_path / "f.parquet", changed(forecasts), sets).startswith(expected)


def test_a_decompression_bomb_is_refused_before_reading(tmp_path, sets, forecasts):
    table = forecasts.assign(window_id="x" * 100_000)
    written = pa.Table.from_pandas(table, preserve_index=False)
    path = tmp_path / "f.parquet"
    pq.write_table(written, path, compression="zstd", use_dictionary=False)
    assert path.stat().st_size < 1_000_000
    with pytest.raises(InputError, match="more than such forecasts take"):
        read_forecasts(path, sets)


def test_narrow_types_any_order_of_columns_and_a_single_set_are_accepted(tmp_path, sets, forecasts):
    path = tmp_path / "f.parquet"
    narrow = forecasts.astype({"px": "float32", "horizon_ms": "int16", "wx": "int64"})
    narrow[sorted(narrow)].to_parquet(path, index=False)
    read = read_forecasts(path, sets)
    assert {name: len(one.states) for name, one in read.items()} == {
        one.name: len(one.windows) for one in sets
    }
    of_one_set = forecasts_of(ZeroPredictor(), window_table(sets[:1]))
    of_one_set.to_parquet(path, index=False)
    assert list(read_forecasts(path, sets)) == [sets[0].name]


@pytest.mark.parametrize("made", ["missing", "text"])
def test_a_file_that_is_no_parquet_table_is_an_error(tmp_path, sets, made):
    path = tmp_path / "f.parquet"
    if made == "text":
        path.write_bytes(b"window_id")
    with pytest.raises(InputError, match="is not a parquet table"):
        read_forecasts(path, sets)
