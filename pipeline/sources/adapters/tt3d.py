"""TT3D: rallies of two amateurs, seen by several cameras, one csv file per recording.

The source is the ground truth of TT3D's benchmark (its folder ``3D_gt``).
"""

from collections.abc import Iterator
from pathlib import Path

from rallygap.pipeline.io.schemas import POSITION_COLUMNS
from rallygap.pipeline.io.source_manifest import Description
from rallygap.pipeline.sources.files import check_header, read_separated
from rallygap.pipeline.sources.folder_source import FolderSource
from rallygap.pipeline.sources.source import NOT_STATED, RawTable

HEADER = "Timestamp,X,Y,Z"

DESCRIPTION = Description(
    name="tt3d",
    kind="rally",
    spin="none",
    licence=NOT_STATED,
    citation="Gossard, Ziegler, Zell: TT3D: Table Tennis 3D Reconstruction, CVPR Workshops 2025",
    note="The set's axes are those of the table frame. Time stamps are of one running clock.",
)


def _recordings(file: Path) -> Iterator[RawTable]:
    check_header(file, HEADER)
    columns = ["t", *POSITION_COLUMNS]
    rows, refusals = read_separated(file, columns, separator=",", first_line=2)
    yield RawTable(file.stem, rows, file, refusals=refusals)


source = FolderSource("tt3d", "*.csv", _recordings, DESCRIPTION)
