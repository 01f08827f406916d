"""The trials of sim2real as a file, with the states of their returns."""

from pathlib import Path

import numpy as np
import pandas as pd
import pandera.pandas as pa

from rallygap.models.ball.types import Floats
from rallygap.pipeline.io.schemas import STATE_COLUMNS, read_checked

# When a predictor forecasts: at every control step, or from the first window alone.
EVERY_STEP, ONCE = "every_tick", "first_window"
PROTOCOLS = {ONCE: "first window", EVERY_STEP: "every control step"}
PHYSICS = "physics"  # the predictor that the others are compared with
SETTING = ["set", "horizons_ms"]  # of a comparison
BASELINE = {"predictor": PHYSICS, "protocol": EVERY_STEP}  # of gains

AFTER = [f"after_{name}" for name in STATE_COLUMNS]  # just after the racket
LANDED = [f"landed_{name}" for name in STATE_COLUMNS]  # just before the landing
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
        error="a return lacks a value",
    ),
    name="played",
    description="trials of sim2real, one row per policy, predictor and shot; the columns used here",
)


def with_states(played: pd.DataFrame, after: Floats, landed: Floats) -> pd.DataFrame:
    """Return trials with the states of returns, which are NaN in other rows.

    Args:
        played: B trials.
        after: (B, 9) just after the racket.
        landed: (B, 9) just before the landing.
    """
    returned = played["returned"].to_numpy()[:, None]
    states = np.where(returned, np.hstack([after, landed]), np.nan)
    columns = pd.DataFrame(states, columns=[*AFTER, *LANDED], index=played.index)
    return pd.concat([played, columns], axis=1)


def read_played(path: Path) -> pd.DataFrame:
    """Read the trials of sim2real.

    Raises:
        InputError: the table is missing or broken.
    """
    return read_checked(path, PLAYED)
