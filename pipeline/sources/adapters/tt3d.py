"""TT3D: rallies of two amateurs, seen by several cameras, one csv file per recording."""

from rallygap.pipeline.io.schemas import POSITION_COLUMNS
from rallygap.pipeline.io.source_manifest import Description
from rallygap.pipeline.sources.files import check_header, read_separated, source_files
from rallygap.pipeline.sources.source import NOT_STATED, RawTable, SourceContext, SourceData

HEADER = "Timestamp,X,Y,Z"

DESCRIPTION = Description(
    name="tt3d",
    kind="rally",
    spin="none",
    licence=NOT_STATED,
    citation="Gossard, Ziegler, Zell: TT3D: Table Tennis 3D Reconstruction, CVPR Workshops 2025",
    note="The set's axes are those of the table frame. Time stamps are of one running clock.",
)


class TT3D:
    """The ground truth of TT3D's benchmark (its folder ``3D_gt``)."""

    name = DESCRIPTION.name

    def read(self, context: SourceContext) -> SourceData:
        """Read every csv file as one recording."""
        tables = []
        for file in source_files(context.folder(self.name), "*.csv"):
            check_header(file, HEADER)
            columns = ["t", *POSITION_COLUMNS]
            rows, refusals = read_separated(file, columns, separator=",", first_line=2)
            tables.append(RawTable(file.stem, rows, file, refusals=refusals))
        return SourceData(DESCRIPTION, tables)


source = TT3D()
