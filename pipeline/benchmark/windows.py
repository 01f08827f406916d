"""The test windows of the last run, exported without their futures; and the tables' contracts."""

import hashlib
from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path

import numpy as np
import pandas as pd
import pandera.pandas as pa
from numpy.typing import NDArray

from rallygap.models.predictors.errors import HORIZONS_MS
from rallygap.models.predictors.protocol import HISTORY, HISTORY_TIMES
from rallygap.pipeline.evaluation.evaluation_windows import MeasuredSet, read_test_sets
from rallygap.pipeline.io.artifacts import write_table, write_text
from rallygap.pipeline.io.markdown import markdown_page
from rallygap.pipeline.io.schemas import POSITION_COLUMNS, SPIN_COLUMNS, VELOCITY_COLUMNS, checked
from rallygap.pipeline.params import Params
from rallygap.pipeline.runtime.errors import InputError

TABLE, README = "windows.parquet", "README.md"
ID_BYTES, DIGITS = 8, 6
_TEMPLATE = Path(__file__).parent / "templates" / "benchmark.md"
LARGEST = 1e6  # m, m/s, rad/s; an error beyond all floats would drop out of the mean
QUANTITIES = {
    "position (m)": POSITION_COLUMNS,
    "velocity (m/s)": VELOCITY_COLUMNS,
    "spin (rad/s)": SPIN_COLUMNS,
}


def _vectors(*quantities: str, note: str, nullable: bool) -> dict[str, pa.Column]:
    """Return three columns a quantity."""
    bounded = pa.Check.in_range(-LARGEST, LARGEST)
    return {
        name: pa.Column(
            float, bounded, nullable=nullable, description=f"{quantity}, {axis} axis{note}"
        )
        for quantity in quantities
        for name, axis in zip(QUANTITIES[quantity], "xyz", strict=True)
    }


WINDOWS = pa.DataFrameSchema(
    {
        "set": pa.Column(str, description="set of measured balls"),
        "window_id": pa.Column(str, description="name of the window; says nothing of its place"),
        "t": pa.Column(float, description="s before the last state, which is at 0"),
        **_vectors("position (m)", "spin (rad/s)", note="; null if not measured", nullable=True),
        **{
            f"{what}_measured": pa.Column(
                bool, description=f"whether the {what} was measured at this instant"
            )
            for what in ("position", "spin")
        },
    },
    unique=["window_id", "t"],
    strict=True,
    ordered=True,
    name="windows",
    description="twelve states a window, 5 ms apart, the last one at t = 0; one row a state",
)

FORECASTS = pa.DataFrameSchema(
    {
        "window_id": pa.Column(str, description="name of a window"),
        "horizon_ms": pa.Column(
            int, pa.Check.isin(HORIZONS_MS), description="ms after the window's last state"
        ),
        **_vectors(*QUANTITIES, note=" at that instant", nullable=False),
    },
    strict=True,
    name="forecasts",
    description="one row a window and horizon; every window of a set, every horizon",
)


def type_of(column: pa.Column) -> str:
    """Return the type of a column as it is called everywhere: string, int64, float64 or bool."""
    name = str(column.dtype)
    return "string" if name.startswith("str") else name  # pandas knows strings of many kinds


def run_sets(root: Path, params: Params) -> list[MeasuredSet]:
    """Return one window per episode of those that the stage evaluate_predictor evaluates.

    Windows of one episode overlap: each would show what came after another.

    Raises:
        InputError: an artefact is missing or broken.
    """
    every = params.evaluate_predictor.window_every_ms / 1000
    return [_one_per_episode(measured) for measured in read_test_sets(root / "artifacts", every)]


def export_windows(sets: Sequence[MeasuredSet], folder: Path) -> None:
    """Write the windows of all sets, without their futures, and what their columns mean.

    Args:
        sets: the windows.
        folder: gets windows.parquet and README.md.

    Raises:
        InputError: the folder cannot be written to.
    """
    contracts = {"windows": WINDOWS, "forecasts": FORECASTS, "type_of": type_of}
    horizons = {"first": HORIZONS_MS[0], "last": HORIZONS_MS[-1]}
    try:
        write_table(folder / TABLE, window_table(sets))
        write_text(folder / README, markdown_page(_TEMPLATE, sets=sets, **horizons, **contracts))
    except OSError as error:
        raise InputError(folder, f"cannot be written to: {error.strerror}") from None


def window_table(sets: Sequence[MeasuredSet]) -> pd.DataFrame:
    """Return the rows of ``WINDOWS``, by set and name: an order that tells nothing."""
    rows = pd.concat([_rows(measured) for measured in sets])
    return checked(rows.sort_values(["set", "window_id", "t"], ignore_index=True), WINDOWS)


def window_ids(measured: MeasuredSet) -> NDArray[np.str_]:
    """Return (B,) names of windows.

    A name is a digest of all that is known of the window, to the micrometre: machines differ in the
    last bits. What came is in it, so that nobody finds recording and time by trying, and forecasts
    of another run's windows meet no window of this one.
    """
    cut = measured.windows
    # Plus zero, because what rounds to nothing may keep its sign.
    parts = [np.round(part, DIGITS) + 0.0 for part in (cut.history.states, cut.anchors, cut.future)]
    names = [
        hashlib.blake2b(
            b"".join([recording.encode(), *(part[row].tobytes() for part in parts)]),
            digest_size=ID_BYTES,
        ).hexdigest()
        for row, recording in enumerate(measured.recordings.tolist())
    ]
    return np.array(names)


def _one_per_episode(measured: MeasuredSet) -> MeasuredSet:
    """Return the set with the window of each episode whose name sorts first: any instant of it."""
    episode_at = {
        (member.recording_id, time): number
        for number, member in enumerate(measured.episodes)
        for time in member.episode.times.tolist()
    }
    ends = zip(measured.recordings.tolist(), measured.windows.anchors.tolist(), strict=True)
    episodes = np.array([episode_at[end] for end in ends])
    by_name = np.argsort(window_ids(measured))
    _, first = np.unique(episodes[by_name], return_index=True)
    rows = by_name[first]
    recordings = measured.recordings[rows]
    return replace(measured, windows=measured.windows[rows], recordings=recordings)


def _rows(measured: MeasuredSet) -> pd.DataFrame:
    history, windows = measured.windows.history, len(measured.windows)
    seen = np.where(history.mask, history.states, np.nan).reshape(-1, 6)
    rows = pd.DataFrame(seen, columns=[*POSITION_COLUMNS, *SPIN_COLUMNS])
    rows.insert(0, "t", np.tile(HISTORY_TIMES.round(3), windows))
    rows.insert(0, "window_id", np.repeat(window_ids(measured), HISTORY))
    rows.insert(0, "set", measured.name)
    for name, columns in (("position", POSITION_COLUMNS), ("spin", SPIN_COLUMNS)):
        rows[f"{name}_measured"] = rows[columns].notna().all(axis=1)
    return rows
