"""SpinDOE: shots of a ball cannon, one csv file each; index.csv has one spin label per shot."""

from pathlib import Path

import pandas as pd

from rallygap.pipeline.io.schemas import POSITION_COLUMNS, SPIN_COLUMNS
from rallygap.pipeline.io.source_manifest import Description
from rallygap.pipeline.sources.files import check_header, read_separated, source_file, source_files
from rallygap.pipeline.sources.source import (
    NOT_STATED,
    RawTable,
    Refusal,
    SourceContext,
    SourceData,
)

INDEX = "index.csv"
INDEX_HEADER = "traj_file,x_spin,y_spin,z_spin"

DESCRIPTION = Description(
    name="spindoe",
    kind="cannon",
    spin="per_recording",
    licence=NOT_STATED,
    citation="Gossard, Tebbe, Ziegler, Zell: SpinDOE: A ball spin estimation method for table "
    "tennis robot, IROS 2023, arXiv 2303.03879",
    note="The set's axes are those of the table frame. Time stamps are rounded to 1 ms. Heights "
    "and spin labels are left as they are, doubtful ones too.",
)


class SpinDOE:
    """SpinDOE's trajectory data set (its ``trajectories.zip``, unpacked)."""

    name = DESCRIPTION.name

    def read(self, context: SourceContext) -> SourceData:
        """Read every csv file but the index as one shot; every sample carries the shot's spin."""
        folder = context.folder(self.name)
        index = source_file(folder, INDEX)
        labels, refusals = _read_labels(index)
        tables = []
        for file in source_files(folder, "[0-9]*.csv"):
            columns = ["t", *POSITION_COLUMNS]
            rows, refused = read_separated(file, columns, separator=";")
            if file.stem in labels.index:
                rows[SPIN_COLUMNS] = labels.loc[file.stem, SPIN_COLUMNS].to_numpy(dtype=float)
            tables.append(RawTable(file.stem, rows, file, refusals=refused))
        missing = [not (folder / f"{stem}.csv").is_file() for stem in labels.index]
        refusals += [
            Refusal(INDEX, row, "label without a file", "label") for row in labels["row"][missing]
        ]
        return SourceData(DESCRIPTION, tables, [index], refusals)


def _read_labels(index: Path) -> tuple[pd.DataFrame, list[Refusal]]:
    """Return the usable labels, named after their files, and the refusals of the others."""
    check_header(index, INDEX_HEADER)
    columns = ["number", *SPIN_COLUMNS]
    rows, unreadable = read_separated(index, columns, separator=",", first_line=2)
    refusals = [refusal._replace(what="label") for refusal in unreadable]
    whole = rows["number"].between(0, 1e9) & (rows["number"] % 1 == 0)
    repeated = whole & rows["number"].duplicated()
    for reason, at_fault in (("no number of a file", ~whole), ("label repeated", repeated)):
        refusals += [Refusal(INDEX, row, reason, "label") for row in rows["row"][at_fault]]
    usable = rows[whole & ~repeated]
    return usable.set_index(usable["number"].map("{:03.0f}".format)), refusals


source = SpinDOE()
