"""ball_prediction of the Intelligent Soft Robots lab: launched balls, many shots per HDF5 file."""

from collections.abc import Iterator
from pathlib import Path
from typing import Any

import h5py
import numpy as np
import pandas as pd

from rallygap.models.ball.state import TABLE_HALF_LENGTH
from rallygap.pipeline.io.frame import Frame
from rallygap.pipeline.io.schemas import POSITION_COLUMNS
from rallygap.pipeline.io.source_manifest import Description
from rallygap.pipeline.runtime.errors import InputError
from rallygap.pipeline.sources.files import source_files
from rallygap.pipeline.sources.source import RawTable, SourceContext, SourceData

GROUP = "originals"
SURFACE_HEIGHT = 0.74  # m above the set's origin
MOST_PACKED = 100  # bytes of samples per byte of file; a small file may claim to hold terabytes

DESCRIPTION = Description(
    name="isr_ball_prediction",
    kind="cannon",
    spin="none",
    licence="BSD 3-Clause (of the repository; none is stated for the data alone)",
    citation="github.com/intelligent-soft-robots/ball_prediction",
    frame=Frame(
        rotation=((0, 1, 0), (-1, 0, 0), (0, 0, 1)), offset=(0, TABLE_HALF_LENGTH, -SURFACE_HEIGHT)
    ),
    note="The set's origin is at the launcher, which shoots along +x, with z up from the floor. "
    "Where the table lies horizontally is not recorded: by convention the launcher stands over "
    "the middle of the far end line and shoots towards -y.",
)


class ISRBallPrediction:
    """The lab's ``mn5008_*`` and ``no_spin_*`` files; their velocities are not used."""

    name = DESCRIPTION.name

    def read(self, context: SourceContext) -> SourceData:
        """Read every shot of every hdf5 file as one recording."""
        files = source_files(context.folder(self.name), "*.hdf5")
        return SourceData(DESCRIPTION, [table for file in files for table in _read_shots(file)])


def _read_shots(file: Path) -> list[RawTable]:
    try:
        with h5py.File(file) as content:
            shots = list(_shots(content, MOST_PACKED * file.stat().st_size))
    except Exception as error:
        # For a damaged file, h5py raises errors of many types.
        reason = " ".join(str(error).split())[:200]
        raise InputError(file, f"is no whole HDF5 file with {GROUP}: {reason}") from None
    return [_table(file, *shot) for shot in shots]


def _shots(content: Any, most: int) -> Iterator[tuple[str, np.ndarray, np.ndarray]]:
    """Yield the key, times (T,) and positions (T, 3) of every shot, in the order of their keys.

    Raises:
        ValueError: a shot is not of this form, or all unpack to more than ``most`` bytes.
    """
    group = content[GROUP]
    if not len(group):
        raise ValueError("there is no shot in it")
    for key in sorted(group, key=lambda key: key.zfill(9)):
        parts = [group[key][name] for name in ("time_stamps", "positions")]
        most -= sum(part.nbytes for part in parts)
        if most < 0:
            raise ValueError("its shots unpack to more than such a file can hold")
        times, positions = (np.asarray(part[()], dtype=float) for part in parts)
        if times.ndim != 1 or positions.shape != (*times.shape, 3):
            raise ValueError(f"shot {key} has {times.shape} times, {positions.shape} positions")
        if not len(times):
            raise ValueError(f"shot {key} has no samples")
        yield key, times, positions


def _table(file: Path, key: str, times: np.ndarray, positions: np.ndarray) -> RawTable:
    rows = pd.DataFrame(positions, columns=POSITION_COLUMNS)
    rows.insert(0, "t", times)
    rows.insert(0, "row", np.arange(1, len(rows) + 1))
    return RawTable(f"{file.stem}_{key.zfill(3)}", rows, file, f"/{GROUP}/{key}")


source = ISRBallPrediction()
