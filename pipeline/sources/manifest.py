"""The manifest: what was read from each source, what was refused and why."""

from collections import defaultdict
from collections.abc import Iterable
from pathlib import Path

from pydantic import BaseModel, ConfigDict

from pipeline.io.artifacts import read_as
from pipeline.sources.source import Description, Refusal


class Refused(BaseModel):
    """What was refused for one reason: how often, and which rows of which place."""

    model_config = ConfigDict(extra="forbid")

    count: int
    rows: dict[str, list[int]]


class FileRecord(BaseModel):
    """A file that was read; its name is relative to the source's folder."""

    model_config = ConfigDict(extra="forbid")

    file: str
    sha256: str


class SourceRecord(Description):
    """What was read from one source.

    Attributes:
        rate_hz: median samples a second, ``None`` for launches.
        recordings: how many were kept.
        launches: how many were kept.
        rows_read: rows of samples or launches in the files.
        rows_kept: those in the table.
        rows_refused: by reason; ``rows_read - rows_kept`` in all.
        labels_refused: spin labels, by reason; their samples are kept without spin.
        files: every file, in the order of reading.
    """

    rate_hz: float | None
    recordings: int
    launches: int
    rows_read: int
    rows_kept: int
    rows_refused: dict[str, Refused]
    labels_refused: dict[str, Refused]
    files: list[FileRecord]


class Manifest(BaseModel):
    """All sources that ingest read, by name."""

    model_config = ConfigDict(extra="forbid")

    sources: dict[str, SourceRecord]

    @property
    def labelled_once(self) -> set[str]:
        """The sources with one spin label a shot."""
        return {name for name, source in self.sources.items() if source.spin == "per_recording"}

    def begins_with_launch(self, recording_id: str) -> bool:
        """Return whether a recording is one shot, seen from its launch on."""
        source, name = recording_id.split("/", 1)
        return self.sources[source].begins_with_launch(name)


def read_manifest(path: Path) -> Manifest:
    """Read the manifest that ingest left.

    Raises:
        InputError: it is missing or is no such manifest.
    """
    return read_as(path, Manifest, "ingest")


def by_reason(refusals: Iterable[Refusal]) -> dict[str, Refused]:
    """Return refusals counted by reason, with their rows by place, in a fixed order."""
    groups: dict[str, list[Refusal]] = defaultdict(list)
    for refusal in refusals:
        groups[refusal.reason].append(refusal)
    return {reason: _refused(groups[reason]) for reason in sorted(groups)}


def _refused(refusals: list[Refusal]) -> Refused:
    rows: dict[str, list[int]] = defaultdict(list)
    for refusal in sorted(refusals):
        rows[refusal.place].append(refusal.row)
    return Refused(count=len(refusals), rows=dict(rows))
