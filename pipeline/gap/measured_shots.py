"""Shot folders: the recordings of a folder, cut into shots."""

import tempfile
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import pandas as pd

from models.gap.fit.shots import Shots
from models.segmentation.settings import SegmentSettings
from models.segmentation.tables import segment_recordings
from models.support.suggestion import suggestion
from pipeline.gap.shots import is_shot, shots_of
from pipeline.io.artifacts import table_writer, write_table
from pipeline.io.episodes import MeasuredEpisode, read_episodes
from pipeline.io.schemas import (
    CONTACTS,
    EPISODES,
    POSITION_COLUMNS,
    RECORDINGS,
    SAMPLES,
    checked,
    empty,
)
from pipeline.io.source_manifest import Manifest
from pipeline.params import IngestSettings
from pipeline.runtime.errors import InputError
from pipeline.sources.registry import registry
from pipeline.sources.source import Source, SourceContext
from pipeline.sources.source_import import SourceImport, in_batches

SIMULATED = "arena"  # the one source that reads no files
DIFFERENCE = np.sqrt(20.0)  # standard deviation of a third difference, in those of its samples
TO_DEVIATION = 1.4826  # from the median size of an error to its standard deviation
LARGEST_NOISE = 0.05  # m, beyond which nothing can be cut


@dataclass(frozen=True)
class MeasuredShots:
    """Shots, and where they come from.

    Attributes:
        name: of the data set.
        shots: unbroken, with enough samples, touching nothing but the table.
        recordings: how many there are.
        refused: implausible rows and labels, counted by reason.
        episodes: how many, from one stroke or launch to the next.
        bounces: how many of the shots bounce.
        noise: m, standard deviation of a coordinate by which they were cut.
    """

    name: str
    shots: Shots
    recordings: int
    refused: dict[str, int]
    episodes: int
    bounces: int
    noise: float


def read_shots(folder: Path | str, source: str) -> MeasuredShots:
    """Read the recordings of a folder and cut them into shots.

    Args:
        folder: with the files of the source.
        source: name of the adapter that reads them.

    Raises:
        InputError: there is no such folder or source, a file is not what the source reads, or
            there are launches without a path.
    """
    parts, manifest = _recordings(Path(folder), _source(source))
    settings = SegmentSettings(noise=_noise(parts))
    episodes = _episodes(parts, manifest, settings)
    record = next(iter(manifest.sources.values()))
    chosen = [member for member in episodes if is_shot(member)]
    return MeasuredShots(
        name=record.name,
        shots=shots_of(chosen),
        recordings=record.recordings,
        refused=record.refused_counts,
        episodes=len(episodes),
        bounces=sum(bool(member.episode.arc.any()) for member in chosen),
        noise=settings.noise,
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


def _recordings(folder: Path, source: Source) -> tuple[list[pd.DataFrame], Manifest]:
    """Return recordings in batches, each of them whole, and their manifest."""
    if not folder.is_dir():
        raise InputError(folder, f"is not a folder; give the one with the files of {source.name}")
    data = source.read(_FolderContext(folder))
    imported = SourceImport(data)
    if imported.is_launches:
        raise InputError(folder, f"{source.name} has launches without a path; give recordings")
    parts = [checked(imported.rows(batch), RECORDINGS) for batch in in_batches(data.tables)]
    return parts, Manifest(sources={data.description.name: imported.record()})


def _noise(parts: Sequence[pd.DataFrame]) -> float:
    """Return the noise of a coordinate, m: the median third difference, at least the usual noise.

    Smooth paths have hardly any third differences, and the median ignores contacts and outliers.
    """
    usual = SegmentSettings().noise
    differences = [part.groupby("recording_id")[POSITION_COLUMNS].diff() for part in parts]
    for _ in range(2):
        differences = [
            rows.groupby(part["recording_id"]).diff()
            for part, rows in zip(parts, differences, strict=True)
        ]
    sizes = np.abs(np.concatenate([rows.dropna().to_numpy().ravel() for rows in differences]))
    if not len(sizes):
        return usual
    return float(np.clip(TO_DEVIATION * np.median(sizes) / DIFFERENCE, usual, LARGEST_NOISE))


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
