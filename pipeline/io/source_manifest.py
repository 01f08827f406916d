"""The manifest of the ingest stage: what was read from each source, what was refused and why."""

from pathlib import Path
from typing import Literal

from pydantic import BaseModel

from rallygap.pipeline.io.artifacts import read_as
from rallygap.pipeline.io.frame import Frame
from rallygap.pipeline.params import Name

PathKind = Literal["cannon", "rally"]


class Description(BaseModel, extra="forbid", frozen=True):
    """A source as its adapter describes it.

    Attributes:
        name: first part of its recordings' ids, and its key in metrics and folders.
        kind: one shot per recording, rallies, or launches (states without a path). A source with
            recordings of both kinds gives the kind of each group, which is the recording's name up
            to its first ``/``.
        spin: whether there is no spin label, one per recording, or one per sample.
        licence: as upstream states it.
        citation: if upstream asks for one.
        frame: transformation into the table frame.
        stated_rate_hz: samples per second as the source states it.
        note: what users of the data must know.
    """

    name: Name
    kind: PathKind | Literal["launches"] | dict[str, PathKind]
    spin: Literal["none", "per_recording", "per_sample"]
    licence: str
    citation: str | None = None
    frame: Frame = Frame()
    stated_rate_hz: float | None = None
    note: str


class Refused(BaseModel, extra="forbid"):
    """Rows refused for one reason: their number, and the rows of each file or data set."""

    count: int
    rows: dict[str, list[int]]


class FileRecord(BaseModel, extra="forbid"):
    """A file that was read; its name is relative to the source's folder."""

    file: str
    sha256: str


class SourceRecord(Description, frozen=True):
    """What was read from one source.

    Attributes:
        rate_hz: median samples per second, ``None`` for launches.
        recordings: number kept.
        launches: number kept.
        rows_read: rows of samples or launches in the files.
        rows_kept: rows in the table.
        rows_refused: by reason; ``rows_read - rows_kept`` in all.
        labels_refused: spin labels, by reason; their samples are kept without spin.
        files: in the order of reading.
    """

    rate_hz: float | None
    recordings: int
    launches: int
    rows_read: int
    rows_kept: int
    rows_refused: dict[str, Refused]
    labels_refused: dict[str, Refused]
    files: list[FileRecord]

    @property
    def refused_counts(self) -> dict[str, int]:
        """Number of refused rows and labels by reason."""
        refused = {**self.rows_refused, **self.labels_refused}
        return {reason: group.count for reason, group in refused.items()}


class Manifest(BaseModel, extra="forbid"):
    """All sources that ingest read, by name."""

    sources: dict[str, SourceRecord]

    @property
    def labelled_once(self) -> set[str]:
        """The sources with one spin label per shot."""
        return {name for name, source in self.sources.items() if source.spin == "per_recording"}

    def starts_with_launch(self, recording_id: str) -> bool:
        """Return whether a recording is a single shot, recorded from its launch on."""
        source, name = recording_id.split("/", 1)
        kind = self.sources[source].kind
        return (kind[name.split("/")[0]] if isinstance(kind, dict) else kind) == "cannon"


def read_manifest(path: Path) -> Manifest:
    """Read the manifest.

    Raises:
        InputError: it is missing or is no such manifest.
    """
    return read_as(path, Manifest, "ingest")
