"""Sources that are a folder of files of one format, each file with one recording or more.

A reader of a format is one function from a file to its recordings. What their numbers mean stands
in the source's description, or in the folder's ``source.yaml`` where users bring their own files.
"""

from collections.abc import Callable, Iterable
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Annotated, Literal

from pydantic import BaseModel, Field, ValidationError

from rallygap.pipeline.io.frame import Frame
from rallygap.pipeline.io.schemas import SPIN_COLUMNS
from rallygap.pipeline.io.source_manifest import Description
from rallygap.pipeline.params import Name, as_json, read_yaml
from rallygap.pipeline.runtime.errors import InputError
from rallygap.pipeline.sources.conversion import Axes, Conversion, Units
from rallygap.pipeline.sources.files import source_files
from rallygap.pipeline.sources.source import RawTable, SourceContext, SourceData

SETTINGS_FILE = "source.yaml"


class FolderSettings(BaseModel, extra="forbid", frozen=True, allow_inf_nan=False):
    """The keys of source.yaml."""

    name: Name
    kind: Literal["cannon", "rally"] = "rally"
    licence: str = "not stated"
    rate: Annotated[float, Field(gt=0)] | None = None
    axes: Axes = ("x", "y", "z")
    units: Units = Units()
    frame: Frame = Frame()


@dataclass(frozen=True)
class FolderSource:
    """A folder of files of one format.

    Attributes:
        name: of the source, and of its folder.
        pattern: of the files' names.
        read_file: gives the recordings of a file. Without a ``description`` their rows have the
            columns ``row``, ``t``, ``x``, ``y``, ``z``, and ``wx``, ``wy``, ``wz`` where there is
            spin, in the units and axes that the folder's ``source.yaml`` states; with one, those
            of ``RawTable``.
        description: of a source whose axes and units are known.
    """

    name: str
    pattern: str
    read_file: Callable[[Path], Iterable[RawTable]]
    description: Description | None = None

    def read(self, context: SourceContext) -> SourceData:
        """Read every file.

        Raises:
            InputError: there is no file, or one is not of this format; or source.yaml is invalid.
        """
        folder = context.folder(self.name)
        if self.description is not None:
            return SourceData(self.description, self._tables(folder))
        settings = self._settings(folder / SETTINGS_FILE)
        conversion = Conversion(axes=settings.axes, units=settings.units)
        tables = [
            replace(table, rows=conversion.to_si(table.rows)) for table in self._tables(folder)
        ]
        has_spin = any(SPIN_COLUMNS[0] in table.rows for table in tables)
        description = Description(
            name=settings.name,
            kind=settings.kind,
            spin="per_sample" if has_spin else "none",
            licence=settings.licence,
            frame=settings.frame,
            stated_rate_hz=settings.rate,
            note=f"Read from {self.name} files as {SETTINGS_FILE} describes them.",
        )
        side_files = [path for path in [folder / SETTINGS_FILE] if path.is_file()]
        return SourceData(description, tables, side_files, conversion=conversion)

    def _tables(self, folder: Path) -> list[RawTable]:
        files = source_files(folder, self.pattern)
        return [table for file in files for table in self.read_file(file)]

    def _settings(self, path: Path) -> FolderSettings:
        if not path.is_file():
            return FolderSettings(name=self.name)
        content = read_yaml(path) or {}
        if isinstance(content, dict):
            content = {"name": self.name, **content}
        try:
            # Strict JSON: the text "200" is no number, and a YAML list is a tuple.
            return FolderSettings.model_validate_json(as_json(content, path), strict=True)
        except ValidationError as error:
            first = error.errors()[0]
            field = ".".join(str(part) for part in first["loc"]) or None
            allowed = ", ".join(FolderSettings.model_fields)
            raise InputError(path, f"{first['msg']} (keys: {allowed})", field=field) from None
