"""The sealed truth of the arena, read back for the oracle and for scores."""

from collections.abc import Mapping
from dataclasses import replace
from pathlib import Path

import numpy as np
import pandas as pd

from rallygap.models.arena.recording import TrueContacts
from rallygap.models.arena.truth import Truth
from rallygap.models.arena.truth_path import true_states
from rallygap.models.ball.simulator import SimulatorError
from rallygap.models.predictors.protocol import FUTURE_TIMES, Bools
from rallygap.models.predictors.windows import Windows
from rallygap.pipeline.io.artifacts import read_json, read_row_groups
from rallygap.pipeline.io.schemas import STATE_COLUMNS, TRUE_CONTACTS, check_columns, checked
from rallygap.pipeline.runtime.errors import InputError


def read_truth(path: Path) -> Truth | None:
    """Read the arena's hidden physics and camera errors; ``None`` where all balls were measured.

    Raises:
        InputError: the file is missing or is no such truth.
    """
    description = read_json(path)
    try:
        return None if description is None else Truth.from_dict(description)
    except (KeyError, TypeError, SimulatorError) as error:
        problem = f"is not the truth of an arena ({error}); run `dvc repro -f ingest`"
        raise InputError(path, problem) from None


def true_windows(
    windows: Windows, recordings: np.ndarray, truth: Truth, contacts: Mapping[str, TrueContacts]
) -> Windows:
    """Return the same windows with the true future in the place of the measured one.

    Args:
        windows: B windows of simulated recordings.
        recordings: (B,) the recording of each.
        truth: the physics behind them.
        contacts: of these recordings.
    """
    future = np.full_like(windows.future, np.nan)
    for name, known in contacts.items():
        rows = recordings == name
        ahead = windows.anchors[rows, None] + FUTURE_TIMES
        times, place = np.unique(ahead, return_inverse=True)
        future[rows] = true_states(truth, known, times)[place.reshape(ahead.shape)]
    measured = windows.measured & np.isfinite(future)
    return replace(windows, future=np.where(measured, future, 0.0), measured=measured)


def net_contacts(
    windows: Windows, recordings: np.ndarray, contacts: Mapping[str, TrueContacts]
) -> Bools:
    """Return (B,) whether the ball truly meets the net within the forecast of each window.

    Arguments are those of ``true_windows``.
    """
    met = np.zeros(len(windows), dtype=bool)
    for name, known in contacts.items():
        rows = recordings == name
        ahead = known.times[known.kinds == "net"] - windows.anchors[rows, None]
        met[rows] = ((ahead > 0) & (ahead <= FUTURE_TIMES[-1])).any(axis=1)
    return met


def read_contacts(path: Path, recordings: np.ndarray) -> dict[str, TrueContacts]:
    """Read the true contacts of some recordings, by name.

    Raises:
        InputError: the table is missing or broken.
    """
    check_columns(path, TRUE_CONTACTS)
    parts = [part[part["recording_id"].isin(recordings)] for part in read_row_groups(path)]
    table = checked(pd.concat(parts, ignore_index=True), TRUE_CONTACTS, path)
    return {
        str(name): TrueContacts(
            rows["t"].to_numpy(), rows["kind"].to_numpy(dtype=str), rows[STATE_COLUMNS].to_numpy()
        )
        for name, rows in table.groupby("recording_id", sort=False)
    }
