"""The tables that pass between stages, as contracts; a table that breaks one stops the stage."""

from pathlib import Path

import numpy as np
import pandas as pd
import pandera.pandas as pa

from rallygap.pipeline.io.artifacts import open_table, read_table
from rallygap.pipeline.runtime.errors import InputError

POSITION_COLUMNS = ["px", "py", "pz"]
VELOCITY_COLUMNS = ["vx", "vy", "vz"]
SPIN_COLUMNS = ["wx", "wy", "wz"]
STATE_COLUMNS = [*POSITION_COLUMNS, *VELOCITY_COLUMNS, *SPIN_COLUMNS]

SPLITS = ("train", "validation", "test", "replay")  # as models/segmentation/split.py gives them

# No measured ball is farther from the table or faster than this; a reader refuses such rows.
FARTHEST_POSITION = 20.0  # m
FASTEST_BALL = 60.0  # m/s
FASTEST_SPIN = 3000.0  # rad/s

HOW_TO_WRITE = "run the stage that writes it"
_EXPLANATIONS = {  # of pandera's checks
    "column_in_dataframe": "is missing",
    "column_in_schema": "is no column of this table",
    "column_ordered": "is out of order",
}


def _number(limit: float | None = None, nullable: bool = False) -> pa.Column:
    finite = pa.Check(np.isfinite, error="must be finite")
    bounded = finite if limit is None else pa.Check.in_range(-limit, limit)
    return pa.Column(float, bounded, nullable=nullable)


def _one_of(*values: str) -> pa.Column:
    return pa.Column(str, pa.Check.isin(values))


def _count(smallest: int) -> pa.Column:
    return pa.Column(int, pa.Check.ge(smallest))


def _schema(
    name: str, columns: dict[str, pa.Column], description: str, checks: pa.Check | None = None
) -> pa.DataFrameSchema:
    return pa.DataFrameSchema(
        columns, checks, strict=True, ordered=True, name=name, description=description
    )


_text, _flag, _id = pa.Column(str), pa.Column(bool), pa.Column(str, unique=True)
_positions = {name: _number(FARTHEST_POSITION) for name in POSITION_COLUMNS}
_velocities = {name: _number(FASTEST_BALL) for name in VELOCITY_COLUMNS}
_spins = {name: _number(FASTEST_SPIN, nullable=True) for name in SPIN_COLUMNS}
_player = _one_of("near", "far")


def _steps(table: pd.DataFrame) -> pd.Series:
    """Return the time from one sample of a recording to the next (s)."""
    return table.groupby("recording_id", sort=False)["t"].diff().dropna()


_time_forward = pa.Check(
    lambda table: (_steps(table) > 0).all(), error="time must grow within every recording"
)

RECORDINGS = _schema(
    "recordings",
    {"recording_id": _text, "t": _number(), **_positions, **_spins},
    "measured balls, one row per sample, raw time stamps (s), table frame",
    _time_forward,
)

LAUNCHES = _schema(
    "launches",
    {"launch_id": _id, **_positions, **_velocities, **_spins},
    "ball states just after a stroke, one row per launch",
)

POINTS = _schema(
    "points",
    {
        "recording_id": _text,
        "start": _number(),
        "end": _number(),
        "server": _player,
        "winner": _player,
        "ended_by": _one_of("net", "out", "double_bounce", "missed"),
        "strokes": _count(1),
    },
    "the umpire's record of simulated games, one row per point",
    pa.Check(lambda table: table["end"] > table["start"], error="end must be after start"),
)

TRUE_CONTACTS = _schema(
    "true_contacts",
    {
        "recording_id": _text,
        "t": _number(),
        "kind": _one_of("launch", "racket", "table", "net", "floor"),
        **_positions,
        **_velocities,
        **{name: _number(FASTEST_SPIN) for name in SPIN_COLUMNS},
    },
    "launches and contacts of a simulated ball, with its true state just after",
    pa.Check(
        lambda table: (_steps(table) >= 0).all(), error="time must not go back within a recording"
    ),
)

SAMPLES = _schema(
    "samples",
    {
        "recording_id": _text,
        "episode_id": _text,
        "arc": _count(0),
        "t": _number(),
        **_positions,
        **{name: _number() for name in VELOCITY_COLUMNS},
        **_spins,
        "outlier": _flag,
    },
    "every episode's measured samples, with arc number, velocity and outlier mark",
    _time_forward,
)

CONTACTS = _schema(
    "contacts",
    {
        "recording_id": _text,
        "episode_id": _text,
        "kind": _one_of("racket", "table", "net", "floor", "unknown"),
        "t": _number(),
        **_positions,
        "speed_change": _number(),
    },
    "breaks of a ball's path: an episode's start, inside it, a rally's end",
)

EPISODES = _schema(
    "episodes",
    {
        "episode_id": _id,
        "recording_id": _text,
        "source": _text,
        "start": _number(),
        "end": _number(),
        "starts_with": _one_of("launch", "racket", "gap", "recording"),
        "ends_with": _one_of("racket", "gap", "recording", "rally_end"),
        "samples": _count(1),
        "outliers": _count(0),
        "bounces": _count(0),
        "residual": _number(),
        "unbroken": _flag,
        "split": _one_of(*SPLITS),
        "replay_set": _one_of("none", "stroke_pro", "stroke_uni", "receive"),
    },
    "one ball from a racket contact (or launch) to the next or to the rally's end",
    pa.Check(
        lambda table: (table.groupby("recording_id")["split"].nunique() == 1).all(),
        error="every recording must be in one split",
    ),
)


def empty(contract: pa.DataFrameSchema) -> pd.DataFrame:
    """Return the table without rows that keeps ``contract``."""
    types = {name: column.dtype.type for name, column in contract.columns.items()}
    return pd.DataFrame(columns=list(types)).astype(types)


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
    with open_table(path) as table:
        names = table.schema_arrow.names
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
    """Return a table if it keeps ``contract``; ``path`` is of its file, if it was read from one.

    Raises:
        InputError: naming the file or table, the first row and column at fault and what is wrong.
    """
    try:
        return contract.validate(table, lazy=True)
    except pa.errors.SchemaErrors as error:
        failure = error.failure_cases.iloc[0]
    where = path or f"table of {contract.name}"
    check, case, column = failure["check"], failure["failure_case"], failure["column"]
    if check in _EXPLANATIONS:
        raise InputError(where, _EXPLANATIONS[check], field=str(case))
    if column == contract.name:
        raise InputError(where, str(check))
    row = None if pd.isna(failure["index"]) else int(failure["index"]) + 1
    raise InputError(where, f"breaks {check}: {case}", row=row, field=str(column))
