"""The returns of replayed balls: their states just after the racket and just before they land."""

from pathlib import Path

import numpy as np
import pandas as pd
import pandera.pandas as pa
from numpy.typing import NDArray

from models.ball.state import STATE_SIZE
from pipeline.io.schemas import STATE_COLUMNS, read_checked

Floats = NDArray[np.float64]

AFTER = [f"after_{name}" for name in STATE_COLUMNS]
LANDED = [f"landed_{name}" for name in STATE_COLUMNS]
KNOWN = ["speed", "net_height", *AFTER, *LANDED]  # of every return

PLAYED = pa.DataFrameSchema(
    {
        **{name: pa.Column(str) for name in ("set", "horizons_ms", "predictor", "protocol")},
        "repeat": pa.Column(int),
        "ball": pa.Column(int, pa.Check.ge(0)),
        "returned": pa.Column(bool),
        **{name: pa.Column(float, nullable=True) for name in KNOWN},
    },
    checks=pa.Check(
        lambda table: bool(table.loc[table["returned"], KNOWN].notna().all(axis=None)),
        error="of a return all must be known",
    ),
    name="played",
    description="trials of sim2real, one row a policy, predictor and shot; the columns used here",
)


def with_states(played: pd.DataFrame, after: Floats, landed: Floats) -> pd.DataFrame:
    """Return trials with the states (R, 9) of their R returns, in columns that others leave empty.

    Args:
        played: one row a ball; ``returned`` says which came back.
        after: just after the racket.
        landed: just before the bounce.
    """
    states = np.full((len(played), 2 * STATE_SIZE), np.nan)
    states[played["returned"].to_numpy(dtype=np.bool_)] = np.column_stack([after, landed])
    return pd.concat(
        [played, pd.DataFrame(states, columns=[*AFTER, *LANDED], index=played.index)], axis=1
    )


def read_played(path: Path) -> pd.DataFrame:
    """Read the trials of sim2real.

    Raises:
        InputError: the table is missing or broken.
    """
    return read_checked(path, PLAYED)
