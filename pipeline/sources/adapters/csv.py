"""A user's recordings: a folder of csv files, one per recording, with an optional source.yaml."""

from collections.abc import Iterator
from pathlib import Path

from rallygap.pipeline.sources.files import check_header, read_separated
from rallygap.pipeline.sources.folder_source import FolderSource
from rallygap.pipeline.sources.source import RawTable

HEADER = "t,x,y,z"
HEADER_WITH_SPIN = "t,x,y,z,wx,wy,wz"


def _recordings(file: Path) -> Iterator[RawTable]:
    columns = check_header(file, HEADER, HEADER_WITH_SPIN).split(",")
    rows, refusals = read_separated(file, columns, separator=",", first_line=2)
    yield RawTable(file.stem, rows, file, refusals=refusals)


source = FolderSource("csv", "*.csv", _recordings)
