"""A user's recordings: a folder of csv files, one per recording, with an optional source.yaml."""

from pathlib import Path
from typing import Annotated, Literal

from pydantic import BaseModel, ConfigDict, Field, ValidationError

from rallygap.pipeline.io.frame import Frame
from rallygap.pipeline.io.schemas import SPIN_COLUMNS
from rallygap.pipeline.io.source_manifest import Description
from rallygap.pipeline.params import Name, as_json, read_yaml
from rallygap.pipeline.runtime.errors import InputError
from rallygap.pipeline.sources.conversion import Axes, Conversion, Units
from rallygap.pipeline.sources.files import check_header, read_separated, source_files
from rallygap.pipeline.sources.source import RawTable, SourceContext, SourceData

HEADER = "t,x,y,z"
HEADER_WITH_SPIN = "t,x,y,z,wx,wy,wz"
SETTINGS_FILE = "source.yaml"


class CSVSettings(BaseModel):
    """The keys of source.yaml."""

    model_config = ConfigDict(extra="forbid", frozen=True, allow_inf_nan=False)

    name: Name = "csv"
    kind: Literal["cannon", "rally"] = "rally"
    licence: str = "not stated"
    rate: Annotated[float, Field(gt=0)] | None = None
    axes: Axes = ("x", "y", "z")
    units: Units = Units()
    frame: Frame = Frame()

    @property
    def conversion(self) -> Conversion:
        """What the columns of the files mean."""
        return Conversion(axes=self.axes, units=self.units)


class CSV:
    """A folder of csv files, with spin or without."""

    name = "csv"

    def read(self, context: SourceContext) -> SourceData:
        """Read every csv file as one recording."""
        folder = context.folder(self.name)
        settings = _read_settings(folder / SETTINGS_FILE)
        tables = [_table(file, settings.conversion) for file in source_files(folder, "*.csv")]
        has_spin = any(SPIN_COLUMNS[0] in table.rows for table in tables)
        description = Description(
            name=settings.name,
            kind=settings.kind,
            spin="per_sample" if has_spin else "none",
            licence=settings.licence,
            frame=settings.frame,
            stated_rate_hz=settings.rate,
            note=f"Read from csv files as {SETTINGS_FILE} describes them.",
        )
        side_files = [path for path in [folder / SETTINGS_FILE] if path.is_file()]
        return SourceData(description, tables, side_files, conversion=settings.conversion)


def _table(file: Path, conversion: Conversion) -> RawTable:
    header = check_header(file, HEADER, HEADER_WITH_SPIN)
    columns = conversion.columns[: header.count(",") + 1]
    rows, refusals = read_separated(file, columns, separator=",", first_line=2)
    return RawTable(file.stem, conversion.to_si(rows), file, refusals=refusals)


def _read_settings(path: Path) -> CSVSettings:
    if not path.is_file():
        return CSVSettings()
    try:
        content = as_json(read_yaml(path) or {}, path)
        # Strict JSON: the text "200" is no number, and a YAML list is a tuple.
        return CSVSettings.model_validate_json(content, strict=True)
    except ValidationError as error:
        first = error.errors()[0]
        field = ".".join(str(part) for part in first["loc"]) or None
        allowed = ", ".join(CSVSettings.model_fields)
        raise InputError(path, f"{first['msg']} (keys: {allowed})", field=field) from None


source = CSV()
