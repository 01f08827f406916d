"""ball_prediction of the Intelligent Soft Robots lab: launched balls, many shots per HDF5 file.

The source is the lab's ``mn5008_*`` and ``no_spin_*`` files; their velocities are not used.
"""

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
from rallygap.pipeline.sources.folder_source import FolderSource
from rallygap.pipeline.sources.source import RawTable

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


def _recordings(file: Path) -> list[RawTable]:
    try:
        with h5py.File(file) as content:
            return list(_shots(file, content))
    except Exception as error:
        # For a damaged file, h5py raises errors of many types.
        reason = " ".join(str(error).split())[:200]
        raise InputError(file, f"is no whole HDF5 file with {GROUP}: {reason}") from None


def _shots(file: Path, content: Any) -> Iterator[RawTable]:
    """Yield every shot, in the order of their keys.

    Raises:
        ValueError: a shot is not of this form, or all unpack to more than a file can hold.
    """
    group, most = content[GROUP], MOST_PACKED * file.stat().st_size
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
        rows = pd.DataFrame(positions, columns=POSITION_COLUMNS)
        rows.insert(0, "t", times)
        rows.insert(0, "row", np.arange(1, len(rows) + 1))
        yield RawTable(f"{file.stem}_{key.zfill(3)}", rows, file, f"/{GROUP}/{key}")


source = FolderSource("isr_ball_prediction", "*.hdf5", _recordings, DESCRIPTION)
