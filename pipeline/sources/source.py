"""The interface of sources: recordings in some format, read into rows of one kind.

A source only reads. ``gather`` transforms rows into the table frame and refuses impossible ones.
"""

import os
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, Literal, NamedTuple, Protocol

import pandas as pd

from rallygap.pipeline.io.schemas import POSITION_COLUMNS, SPIN_COLUMNS, STATE_COLUMNS
from rallygap.pipeline.io.source_manifest import Description
from rallygap.pipeline.params import IngestSettings
from rallygap.pipeline.runtime.errors import InputError
from rallygap.pipeline.runtime.paths import repository_root
from rallygap.pipeline.sources.conversion import Conversion

FOLDER_VARIABLE = "RALLYGAP_DATA"  # environment variable; the setting takes precedence
NOT_STATED = "not stated upstream"
SAMPLE_COLUMNS = ["t", *POSITION_COLUMNS, *SPIN_COLUMNS]  # of a recording
LAUNCH_COLUMNS = ["id", *STATE_COLUMNS]


class Refusal(NamedTuple):
    """A row, or (``what = "label"``) a spin label, that is refused.

    ``place`` is the file inside the source's folder, followed by the data set if the file has
    several; ``row`` the 1-based line or sample there.
    """

    place: str
    row: int
    reason: str
    what: Literal["row", "label"] = "row"


@dataclass(frozen=True)
class RawTable:
    """The rows of one recording, or of one set of launches, as the file states them.

    Attributes:
        name: of the recording or set, inside its source.
        rows: column ``row`` (1-based line or sample in the file), then ``SAMPLE_COLUMNS`` or
            ``LAUNCH_COLUMNS``, in the source's own axes; NaN where there is no number. Spin may be
            left out.
        file: ``None`` for simulated recordings.
        part: the data set inside the file, if there are several.
        refusals: rows that the reader cannot parse.
        extra_tables: of a simulated recording: rows of the tables ``points`` and
            ``true_contacts``, without the column ``recording_id``.
    """

    name: str
    rows: pd.DataFrame
    file: Path | None = None
    part: str = ""
    refusals: Sequence[Refusal] = ()
    extra_tables: Mapping[str, pd.DataFrame] = field(default_factory=dict)

    @property
    def place(self) -> str:
        """File and data set of the rows, for messages."""
        return f"{self.file.name}{self.part}" if self.file else self.name


@dataclass(frozen=True)
class SourceData:
    """The content of a source.

    Attributes:
        description: of the source.
        tables: its recordings, or its sets of launches; iterated once, so that they need not fit
            into memory together.
        side_files: files without rows, such as an index of labels.
        refusals: outside the tables.
        truth: the physics of a simulated source.
        conversion: that the user's settings of the source state; ``None`` where an adapter fixes
            axes and units.
    """

    description: Description
    tables: Iterable[RawTable]
    side_files: Sequence[Path] = ()
    refusals: Sequence[Refusal] = ()
    truth: dict[str, Any] | None = None
    conversion: Conversion | None = None


@dataclass(frozen=True)
class SourceContext:
    """Settings and seed of a run."""

    settings: IngestSettings
    seed: int

    def folder(self, name: str) -> Path:
        """Return the folder of source ``name``; a relative setting is relative to the repository.

        Raises:
            InputError: there is none, or neither setting nor environment variable is set.
        """
        sources = self.settings.folder or os.environ.get(FOLDER_VARIABLE)
        if not sources:
            problem = f"is not set, nor is {FOLDER_VARIABLE}: give the folder that holds {name}/"
            raise InputError("params.yaml", problem, field="ingest.folder")
        folder = repository_root() / sources / name
        try:
            is_folder = folder.is_dir()
        except OSError as error:  # a parent without permission, a name that is too long
            raise InputError(folder, f"cannot be read: {error.strerror}") from None
        if not is_folder:
            problem = f"there is no such folder; set ingest.folder or {FOLDER_VARIABLE}"
            raise InputError(folder, problem)
        return folder


class Source(Protocol):
    """A set of recordings; each module of ``adapters`` has one under the name ``source``."""

    @property
    def name(self) -> str:
        """The name under which settings list the source."""

    def read(self, context: SourceContext) -> SourceData:
        """Read everything.

        Raises:
            InputError: a file or folder as a whole is not what this source reads.
        """
