"""Forecasts of the test windows, read from a parquet file and checked row by row."""

from collections.abc import Sequence
from pathlib import Path

import numpy as np
import pandas as pd
import pyarrow as pa
from numpy.typing import NDArray
from pyarrow.parquet import ParquetFile

from rallygap.models.predictors.errors import EVALUATED, HORIZONS_MS
from rallygap.models.predictors.protocol import FUTURE, Forecast
from rallygap.pipeline.benchmark.windows import FORECASTS, type_of, window_ids
from rallygap.pipeline.evaluation.evaluation_windows import MeasuredSet
from rallygap.pipeline.io.schemas import STATE_COLUMNS, checked
from rallygap.pipeline.runtime.errors import InputError

LARGEST_ROW = 200  # bytes; a row has ten numbers and a name
LONGEST_SHOWN = 40  # characters
KEYS = ["window_id", "horizon_ms"]
_ARROW = {"string": pa.string(), "int64": pa.int64(), "float64": pa.float64()}
EXPORT = "run `rallygap benchmark export` for the windows of this run"


def read_forecasts(path: Path, sets: Sequence[MeasuredSet]) -> dict[str, Forecast]:
    """Read forecasts of all windows of one or more sets.

    Args:
        path: of a parquet table that keeps ``FORECASTS``, its rows in any order.
        sets: the windows that there are.

    Returns:
        Set to the forecasts of its windows, in their order; zero before the first horizon. A set
        of which no window is forecast is left out.

    Raises:
        InputError: the file is missing, is no such table, or forecasts unknown windows, a window
            twice or not at all; naming the row and field.
    """
    ids = {measured.name: window_ids(measured) for measured in sets}
    set_of = {name: of for of, names in ids.items() for name in names.tolist()}
    table = checked(_read(path, rows=len(set_of) * len(HORIZONS_MS)), FORECASTS, path)
    if table.empty:
        raise InputError(path, f"has no row; {EXPORT} and forecast them")
    of = table["window_id"].map(set_of)
    _refuse_first(of.isna(), table, path, f"is no window of this run; {EXPORT}")
    _refuse_first(table.duplicated(KEYS), table, path, "has this horizon twice; keep one row")
    return {name: _forecast(table[of == name], ids[name], path) for name in ids if name in set(of)}


def _read(path: Path, rows: int) -> pd.DataFrame:
    """Read a table of the right columns and not too many rows."""
    try:
        with ParquetFile(path) as content:
            _check_columns(content.schema_arrow, path)
            if content.metadata.num_rows > rows:
                problem = f"has {content.metadata.num_rows} rows; all windows have {rows} horizons"
                raise InputError(path, f"{problem}. Give each once")
            groups = range(content.metadata.num_row_groups)
            size = sum(content.metadata.row_group(group).total_byte_size for group in groups)
            if size > LARGEST_ROW * (rows + len(HORIZONS_MS)):
                raise InputError(path, f"unpacks to {size} bytes, more than such forecasts take")
            # Networks give 32 bits.
            columns = FORECASTS.columns.items()
            wide = pa.schema([(name, _ARROW[type_of(column)]) for name, column in columns])
            table = content.read().select(wide.names).cast(wide)
            return table.to_pandas(ignore_metadata=True)
    except (OSError, ValueError, KeyError, TypeError, NotImplementedError, MemoryError) as error:
        reason = " ".join(str(error).split())[:200]
        raise InputError(path, f"is not a parquet table: {reason}") from None


def _check_columns(schema: pa.Schema, path: Path) -> None:
    """Raise unless the columns are those of ``FORECASTS``, in any order and of any width."""
    for name in FORECASTS.columns:
        if schema.names.count(name) != 1:
            problem = "is missing" if name not in schema.names else "is there twice"
            raise InputError(path, f"{problem}; {EXPORT} and their README.md", field=name)
        present, wanted = schema.field(name).type, type_of(FORECASTS.columns[name])
        if not _fits(present, wanted):
            raise InputError(path, f"has the type {present}; give {wanted}", field=name)
    for name in schema.names:
        if name not in FORECASTS.columns:
            raise InputError(path, "is no column of forecasts; leave it out", field=name)


def _fits(present: pa.DataType, wanted: str) -> bool:
    """Return whether a column can be widened to what is wanted without loss of meaning."""
    if wanted == "string":
        return bool(pa.types.is_string(present) or pa.types.is_large_string(present))
    if wanted == "int64":
        return bool(pa.types.is_integer(present))
    return bool(pa.types.is_integer(present) or pa.types.is_floating(present))


def _refuse_first(at_fault: "pd.Series[bool]", table: pd.DataFrame, path: Path, what: str) -> None:
    """Raise for the first row at fault, if there is one."""
    if at_fault.any():
        row = int(at_fault.to_numpy().argmax())
        name = str(table["window_id"].iloc[row])[:LONGEST_SHOWN]
        raise InputError(path, f"{name} {what}", row=row + 1, field="window_id")


def _forecast(table: pd.DataFrame, ids: NDArray[np.str_], path: Path) -> Forecast:
    """Return the rows of one set as a forecast of its windows."""
    rows = table.set_index(KEYS)
    wanted = pd.MultiIndex.from_product([ids, HORIZONS_MS], names=KEYS)
    missing = wanted[~wanted.isin(rows.index)]
    if len(missing):
        name, horizon = missing[0]
        problem = (
            f"window {name} has no row for {horizon} ms, and {len(missing) - 1} more are missing; "
            f"forecast every window at {HORIZONS_MS[0]}, {HORIZONS_MS[1]}, … {HORIZONS_MS[-1]} ms"
        )
        raise InputError(path, problem)
    states = np.zeros((len(ids), FUTURE, len(STATE_COLUMNS)))
    forecast = rows.loc[wanted, STATE_COLUMNS].to_numpy()
    states[:, EVALUATED] = forecast.reshape(len(ids), len(HORIZONS_MS), len(STATE_COLUMNS))
    return Forecast(states, np.ones(len(ids), dtype=bool))
