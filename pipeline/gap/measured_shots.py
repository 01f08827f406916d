"""Shot folders: the recordings of a folder, cut into shots."""

import tempfile
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path

import pandas as pd

from rallygap.models.gap.fit.shots import Shots
from rallygap.models.gap.net.contacts import NetContacts
from rallygap.models.segmentation.settings import SegmentSettings
from rallygap.models.segmentation.tables import segment_recordings
from rallygap.models.support.suggestion import suggestion
from rallygap.pipeline.gap.data_check.check import check_recordings
from rallygap.pipeline.gap.labels import LabelCounts, count_labels
from rallygap.pipeline.gap.noise import coordinate_noise
from rallygap.pipeline.gap.shots import shots_of, source_shots
from rallygap.pipeline.io.artifacts import table_writer, write_table
from rallygap.pipeline.io.episodes import MeasuredEpisode, read_episodes
from rallygap.pipeline.io.schemas import (
    CONTACTS,
    EPISODES,
    POSITION_COLUMNS,
    RECORDINGS,
    SAMPLES,
    checked,
    empty,
)
from rallygap.pipeline.io.source_manifest import Manifest
from rallygap.pipeline.params import IngestSettings
from rallygap.pipeline.runtime.errors import InputError
from rallygap.pipeline.sources.registry import registry
from rallygap.pipeline.sources.source import Source, SourceContext
from rallygap.pipeline.sources.source_import import SourceImport, in_batches

SIMULATED = "arena"  # the one source that reads no files


@dataclass(frozen=True)
class MeasuredShots:
    """Shots, and where they come from.

    Attributes:
        name: of the data set.
        shots: unbroken, with enough samples, up to the first touch of anything but the table.
        nets: contacts with the net.
        recordings: how many there are.
        refused: implausible rows and labels, counted by reason.
        episodes: how many, from one stroke or launch to the next.
        left_out: episodes that are no shots, counted by reason.
        labels: spin labels, of which some are used.
        bounces: how many of the shots bounce.
        noise: m, standard deviation of a coordinate by which they were cut.
        doubts: what is doubtful about the recordings, one sentence each.
    """

    name: str
    shots: Shots
    nets: NetContacts
    recordings: int
    refused: dict[str, int]
    episodes: int
    left_out: dict[str, int]
    labels: LabelCounts
    bounces: int
    noise: float
    doubts: tuple[str, ...] = ()


def read_shots(folder: Path | str, source: str) -> MeasuredShots:
    """Read the recordings of a folder and cut them into shots.

    Args:
        folder: with the files of the source.
        source: name of the adapter that reads them.

    Raises:
        InputError: there is no such folder or source, a file is not what the source reads, or
            there are launches without a path.
    """
    parts, manifest, doubts = _recordings(Path(folder), _source(source))
    settings = SegmentSettings(noise=_noise(parts))
    episodes = _episodes(parts, manifest, settings)
    record = next(iter(manifest.sources.values()))
    found = source_shots(episodes)
    return MeasuredShots(
        name=record.name,
        shots=shots_of(found.members),
        nets=found.nets,
        recordings=record.recordings,
        refused=record.refused_counts,
        episodes=len(episodes),
        left_out=found.left_out,
        labels=count_labels(parts, record, found.members),
        bounces=sum(bool(member.episode.arc.any()) for member in found.members),
        noise=settings.noise,
        doubts=doubts,
    )


class _FolderContext(SourceContext):
    """The context of a source whose files are in this folder."""

    def __init__(self, folder: Path) -> None:
        super().__init__(IngestSettings.model_construct(folder=folder), seed=0)

    def folder(self, name: str) -> Path:
        return Path(str(self.settings.folder))


def _source(name: str) -> Source:
    known = {key: source for key, source in registry().items() if key != SIMULATED}
    if name not in known:
        problem = f"there is no source {name!r} of measured balls; {suggestion(name, known)}"
        raise InputError("--source", problem)
    return known[name]


def read_recordings(folder: Path, source: str) -> list[pd.DataFrame]:
    """Return the rows of the recordings of a folder, in parts of whole recordings.

    Args:
        folder: with the files of the source.
        source: name of the adapter that reads them.

    Raises:
        InputError: as ``read_shots`` does.
    """
    return _recordings(folder, _source(source))[0]


def read_measured_episodes(folder: Path, source: str) -> list[MeasuredEpisode]:
    """Return the episodes of the recordings of a folder.

    Args:
        folder: with the files of the source.
        source: name of the adapter that reads them.

    Raises:
        InputError: as ``read_shots`` does.
    """
    parts, manifest, _ = _recordings(folder, _source(source))
    return _episodes(parts, manifest, SegmentSettings(noise=_noise(parts)))


def _recordings(
    folder: Path, source: Source
) -> tuple[list[pd.DataFrame], Manifest, tuple[str, ...]]:
    """Return recordings in batches, each of them whole, their manifest, and what is doubtful."""
    if not folder.is_dir():
        raise InputError(folder, f"is not a folder; give the one with the files of {source.name}")
    data = source.read(_FolderContext(folder))
    imported = SourceImport(data)
    if imported.is_launches:
        raise InputError(folder, f"{source.name} has launches without a path; give recordings")
    tables = list(data.tables)
    doubts = check_recordings(tables, data.description.frame, data.conversion, folder)
    parts = [checked(imported.rows(batch), RECORDINGS) for batch in in_batches(tables)]
    return parts, Manifest(sources={data.description.name: imported.record()}), doubts


def _noise(parts: Sequence[pd.DataFrame]) -> float:
    groups = (part.groupby("recording_id")[POSITION_COLUMNS] for part in parts)
    return coordinate_noise([rows.to_numpy() for group in groups for _, rows in group])


def _episodes(
    parts: Sequence[pd.DataFrame], manifest: Manifest, settings: SegmentSettings
) -> list[MeasuredEpisode]:
    """Cut recordings into temporary files, and read them like files of the segment stage."""
    with tempfile.TemporaryDirectory(prefix="rallygap.") as name:
        folder = Path(name)
        contacts, episodes = zip(*_cut(folder, parts, manifest, settings), strict=True)
        # No episode is reserved for another purpose here.
        whole = pd.concat(episodes, ignore_index=True).assign(split="test", replay_set="none")
        write_table(folder / "episodes.parquet", checked(whole, EPISODES))
        found = checked(pd.concat(contacts, ignore_index=True), CONTACTS)
        write_table(folder / "contacts.parquet", found)
        return read_episodes(folder, manifest.labelled_once)


def _cut(
    folder: Path, parts: Sequence[pd.DataFrame], manifest: Manifest, settings: SegmentSettings
) -> Iterator[tuple[pd.DataFrame, pd.DataFrame]]:
    """Write the samples of all episodes, and yield their contacts and the episodes."""
    with table_writer(folder / "samples.parquet", empty(SAMPLES)) as add:
        for recordings in parts:
            found = segment_recordings(recordings, manifest.starts_with_launch, settings)
            add(checked(found.samples, SAMPLES))
            yield found.contacts, found.episodes
