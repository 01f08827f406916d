"""What a source is: measured balls in some format, read into rows of one kind.

A source only reads. Moving rows into the table frame and refusing impossible ones is the same for
all of them and happens in ``gather``.
"""

import os
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, Literal, NamedTuple, Protocol

import pandas as pd
from pydantic import BaseModel, ConfigDict

from pipeline.runtime.errors import InputError
from pipeline.sources.files import SourceFile
from pipeline.sources.frame import Frame
from pipeline.sources.settings import IngestSettings, SourceName

FOLDER_VARIABLE = "RALLYGAP_DATA"  # environment variable; the setting goes first
NOT_STATED = "not stated upstream"

PathKind = Literal["cannon", "rally"]


class Description(BaseModel):
    """What there is to say about a source before a row of it is read.

    Attributes:
        name: identifier, first part of its recordings' ids.
        kind: one shot a recording, rallies, or launches (states without a path). A source that has
            recordings of both kinds says it of each group, the recording's name up to its first
            ``/``.
        spin: whether balls carry no spin label, one a recording, or one a sample.
        licence: as upstream states it.
        citation: whom to name, where upstream says so.
        frame: how the source's axes lie in the table frame.
        stated_rate_hz: samples a second as the source states it.
        note: what a reader of the data must know.
    """

    model_config = ConfigDict(extra="forbid", frozen=True)

    name: SourceName
    kind: PathKind | Literal["launches"] | dict[str, PathKind]
    spin: Literal["none", "per_recording", "per_sample"]
    licence: str
    citation: str | None = None
    frame: Frame = Frame()
    stated_rate_hz: float | None = None
    note: str

    def begins_with_launch(self, name: str) -> bool:
        """Return whether the recording ``name`` is one shot, seen from its launch on."""
        kind = self.kind
        return (kind[name.split("/")[0]] if isinstance(kind, dict) else kind) == "cannon"


class Refusal(NamedTuple):
    """Something that is not taken over: a row, or (``what = "label"``) a spin label.

    ``place`` is the file inside the source's folder, with the data set inside it where it has
    several; ``row`` the 1-based line or sample there.
    """

    place: str
    row: int
    reason: str
    what: Literal["row", "label"] = "row"


@dataclass(frozen=True)
class RawTable:
    """The rows of one recording, or of one set of launches, as their file states them.

    Attributes:
        name: of the recording or set, inside its source.
        rows: column ``row`` (1-based line or sample in the file), then those of a recording
            (``t``, positions, spins) or of launches (``id``, positions, velocities, spins), in the
            source's own axes; NaN where there is no number. Spin may be left out.
        file: where the rows come from; ``None`` if from no file.
        part: the data set inside the file, where it has several.
        refusals: what the reader could not make out.
        beside: what a simulated recording knows of itself: rows of the tables ``points`` and
            ``true_contacts``, without the column ``recording_id``.
    """

    name: str
    rows: pd.DataFrame
    file: SourceFile | None = None
    part: str = ""
    refusals: Sequence[Refusal] = ()
    beside: Mapping[str, pd.DataFrame] = field(default_factory=dict)

    @property
    def place(self) -> str:
        """Where the rows are, for people."""
        return f"{self.file}{self.part}" if self.file else self.name


@dataclass(frozen=True)
class SourceData:
    """All that a source holds.

    Attributes:
        description: what there is to say about it.
        tables: its recordings, or its sets of launches; taken one by one and only once, so that
            they need not fit into memory together.
        side_files: files that hold no rows, such as an index of labels.
        refusals: what was refused outside the tables.
        truth: of a simulated source, what its physics is.
    """

    description: Description
    tables: Iterable[RawTable]
    side_files: Sequence[SourceFile] = ()
    refusals: Sequence[Refusal] = ()
    truth: dict[str, Any] | None = None


@dataclass(frozen=True)
class SourceContext:
    """What a source may need to know of the run."""

    settings: IngestSettings
    seed: int

    def folder(self, name: str) -> Path:
        """Return the folder of source ``name``.

        Raises:
            InputError: there is none, or the setting that says where is empty.
        """
        sources = self.settings.folder or os.environ.get(FOLDER_VARIABLE)
        if not sources:
            problem = f"is not set, nor is {FOLDER_VARIABLE}: give the folder that holds {name}/"
            raise InputError("params.yaml", problem, field="ingest.folder")
        folder = Path(sources) / name
        try:
            found = folder.is_dir()
        except OSError as error:  # a parent that may not be searched, a name that is too long
            raise InputError(folder, f"cannot be read: {error.strerror}") from None
        if not found:
            problem = (
                f"there is no such folder; ingest.folder or {FOLDER_VARIABLE} says where to look"
            )
            raise InputError(folder, problem)
        return folder


class Source(Protocol):
    """A set of measured balls; each module of ``adapters`` has one under the name ``source``."""

    @property
    def name(self) -> str:
        """The name under which settings list the source."""

    def read(self, context: SourceContext) -> SourceData:
        """Read everything.

        Raises:
            InputError: a file or folder as a whole is not what this source reads.
        """
