"""The tables that pass between stages, as contracts; a table that breaks one stops the stage."""

from pathlib import Path

import numpy as np
import pandas as pd
import pandera.pandas as pa

from pipeline.io.artifacts import read_column_names, read_table
from pipeline.runtime.errors import InputError

POSITION_COLUMNS = ["px", "py", "pz"]
VELOCITY_COLUMNS = ["vx", "vy", "vz"]
SPIN_COLUMNS = ["wx", "wy", "wz"]
STATE_COLUMNS = [*POSITION_COLUMNS, *VELOCITY_COLUMNS, *SPIN_COLUMNS]

SPLITS = ("train", "validation", "test", "replay")  # as models/segmentation/split.py gives them

# No measured ball is farther from the table or faster than this; a reader refuses such rows.
FARTHEST_POSITION = 20.0  # m
FASTEST_BALL = 60.0  # m/s
FASTEST_SPIN = 3000.0  # rad/s


_finite = pa.Check(np.isfinite, error="must be finite")


def _number(limit: float | None = None, nullable: bool = False) -> pa.Column:
    bounded = _finite if limit is None else pa.Check.in_range(-limit, limit)
    return pa.Column(float, bounded, nullable=nullable)


_positions = {name: _number(FARTHEST_POSITION) for name in POSITION_COLUMNS}
_velocities = {name: _number(FASTEST_BALL) for name in VELOCITY_COLUMNS}
_spins = {name: _number(FASTEST_SPIN, nullable=True) for name in SPIN_COLUMNS}

_player = pa.Column(str, pa.Check.isin(["near", "far"]))

_time_forward = pa.Check(
    lambda table: (table.groupby("recording_id", sort=False)["t"].diff().dropna() > 0).all(),
    error="time must grow within every recording",
)

RECORDINGS = pa.DataFrameSchema(
    {"recording_id": pa.Column(str), "t": _number(), **_positions, **_spins},
    checks=_time_forward,
    strict=True,
    ordered=True,
    name="recordings",
    description="measured balls, one row a sample, raw time stamps (s), table frame",
)

LAUNCHES = pa.DataFrameSchema(
    {"launch_id": pa.Column(str, unique=True), **_positions, **_velocities, **_spins},
    strict=True,
    ordered=True,
    name="launches",
    description="ball states just after a stroke, one row a launch",
)

POINTS = pa.DataFrameSchema(
    {
        "recording_id": pa.Column(str),
        "start": _number(),
        "end": _number(),
        "server": _player,
        "winner": _player,
        "ended_by": pa.Column(str, pa.Check.isin(["net", "out", "double_bounce", "missed"])),
        "strokes": pa.Column(int, pa.Check.ge(1)),
    },
    checks=pa.Check(lambda table: table["end"] > table["start"], error="end must be after start"),
    strict=True,
    ordered=True,
    name="points",
    description="the umpire's record of simulated games, one row a point",
)

TRUE_CONTACTS = pa.DataFrameSchema(
    {
        "recording_id": pa.Column(str),
        "t": _number(),
        "kind": pa.Column(str, pa.Check.isin(["launch", "racket", "table", "net", "floor"])),
        **_positions,
        **_velocities,
        **{name: _number(FASTEST_SPIN) for name in SPIN_COLUMNS},
    },
    checks=pa.Check(
        lambda table: (table.groupby("recording_id", sort=False)["t"].diff().dropna() >= 0).all(),
        error="time must not go back within a recording",
    ),
    strict=True,
    ordered=True,
    name="true_contacts",
    description="everything that changed a simulated ball, with its true state just after",
)

SAMPLES = pa.DataFrameSchema(
    {
        "recording_id": pa.Column(str),
        "episode_id": pa.Column(str),
        "arc": pa.Column(int, pa.Check.ge(0)),
        "t": _number(),
        **_positions,
        **{name: _number() for name in VELOCITY_COLUMNS},
        **_spins,
        "outlier": pa.Column(bool),
    },
    checks=_time_forward,
    strict=True,
    ordered=True,
    name="samples",
    description="every episode's measured samples, with arc number, velocity and outlier mark",
)

CONTACTS = pa.DataFrameSchema(
    {
        "recording_id": pa.Column(str),
        "episode_id": pa.Column(str),
        "kind": pa.Column(str, pa.Check.isin(["racket", "table", "floor", "unknown"])),
        "t": _number(),
        **_positions,
        "speed_change": _number(),
    },
    strict=True,
    ordered=True,
    name="contacts",
    description="where a ball's path breaks: an episode's start, inside it, a rally's end",
)

EPISODES = pa.DataFrameSchema(
    {
        "episode_id": pa.Column(str, unique=True),
        "recording_id": pa.Column(str),
        "source": pa.Column(str),
        "start": _number(),
        "end": _number(),
        "starts_with": pa.Column(str, pa.Check.isin(["launch", "racket", "gap", "recording"])),
        "ends_with": pa.Column(str, pa.Check.isin(["racket", "gap", "recording", "rally_end"])),
        "samples": pa.Column(int, pa.Check.ge(1)),
        "outliers": pa.Column(int, pa.Check.ge(0)),
        "bounces": pa.Column(int, pa.Check.ge(0)),
        "residual": _number(),
        "unbroken": pa.Column(bool),
        "split": pa.Column(str, pa.Check.isin(SPLITS)),
        "replay_set": pa.Column(
            str, pa.Check.isin(["none", "stroke_pro", "stroke_uni", "receive"])
        ),
    },
    checks=pa.Check(
        lambda table: (table.groupby("recording_id")["split"].nunique() == 1).all(),
        error="every recording must be in one split",
    ),
    strict=True,
    ordered=True,
    name="episodes",
    description="one ball from a racket contact (or launch) to the next or to the rally's end",
)


def empty(contract: pa.DataFrameSchema) -> pd.DataFrame:
    """Return the table without rows that keeps ``contract``."""
    types = {name: column.dtype.type for name, column in contract.columns.items()}
    return pd.DataFrame(columns=list(types)).astype(types)


HOW_TO_WRITE = "run the stage that writes it"

_EXPLANATIONS = {
    "column_in_dataframe": "is missing",
    "column_in_schema": "is no column of this table",
    "column_ordered": "is out of order",
}


def read_checked(path: Path, contract: pa.DataFrameSchema) -> pd.DataFrame:
    """Read a parquet table that keeps ``contract``.

    Raises:
        InputError: it is missing, is no parquet table, or breaks the contract; as ``checked``.
    """
    check_columns(path, contract)
    return checked(read_table(path), contract, path)


def check_columns(path: Path, contract: pa.DataFrameSchema) -> None:
    """Raise unless a parquet table has the columns of ``contract``, before any row is read.

    Raises:
        InputError: it is missing, is no parquet table, or has other columns.
    """
    names = read_column_names(path)
    for name in contract.columns:
        if names.count(name) != 1:
            problem = "is there twice" if name in names else "is missing"
            raise InputError(path, f"{problem}; {HOW_TO_WRITE}", field=name)
    for name in names if contract.strict else []:
        if name not in contract.columns:
            raise InputError(path, f"is no column of this table; {HOW_TO_WRITE}", field=name)


def checked(
    table: pd.DataFrame, contract: pa.DataFrameSchema, path: Path | None = None
) -> pd.DataFrame:
    """Return ``table`` if it keeps ``contract``.

    Args:
        table: made or read.
        contract: that it must keep.
        path: of the file it was read from, if any.

    Raises:
        InputError: naming the file or table, the first row and column at fault and what is wrong.
    """
    try:
        return contract.validate(table, lazy=True)
    except pa.errors.SchemaErrors as error:
        failure = error.failure_cases.iloc[0]
        raise _broken(path or f"table of {contract.name}", contract, failure) from None


def _broken(where: Path | str, contract: pa.DataFrameSchema, failure: pd.Series) -> InputError:
    """Return the error for one failure case of pandera."""
    check, case, column = failure["check"], failure["failure_case"], failure["column"]
    if check in _EXPLANATIONS:
        return InputError(where, _EXPLANATIONS[check], field=str(case))
    if column == contract.name:
        return InputError(where, str(check))
    row = None if pd.isna(failure["index"]) else int(failure["index"]) + 1
    return InputError(where, f"breaks {check}: {case}", row=row, field=str(column))
