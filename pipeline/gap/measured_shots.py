"""Shot folders: the recordings of a folder, cut into shots."""

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path

import numpy as np
import pandas as pd

from rallygap.models.gap.fit.shots import Shots
from rallygap.models.gap.net.contacts import NetContacts
from rallygap.models.segmentation.settings import SegmentSettings
from rallygap.models.segmentation.tables import segment_recordings
from rallygap.models.support.suggestion import suggestion
from rallygap.pipeline.gap.data_check.check import check_recordings
from rallygap.pipeline.gap.data_check.measured import coordinate_noise
from rallygap.pipeline.gap.shots import shots_of, source_shots
from rallygap.pipeline.io.episodes import MeasuredEpisode, episodes_of
from rallygap.pipeline.io.schemas import (
    CONTACTS,
    EPISODES,
    POSITION_COLUMNS,
    RECORDINGS,
    SPIN_COLUMNS,
    checked,
)
from rallygap.pipeline.io.source_manifest import Manifest, SourceRecord
from rallygap.pipeline.params import IngestSettings
from rallygap.pipeline.runtime.errors import InputError
from rallygap.pipeline.sources.registry import registry
from rallygap.pipeline.sources.source import SourceContext
from rallygap.pipeline.sources.source_import import SourceImport, in_batches

SIMULATED = "arena"  # the one source that reads no files


@dataclass(frozen=True)
class LabelCounts:
    """Spin labels of recordings; a label for a whole recording counts once.

    Attributes:
        read: how many the files have.
        implausible: how many of them are refused.
        used: how many are in shots.
    """

    read: int
    implausible: int
    used: int

    @property
    def elsewhere(self) -> int:
        """How many are plausible but in no shot."""
        return self.read - self.implausible - self.used


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


@dataclass(frozen=True)
class Recordings:
    """The recordings of a folder.

    Attributes:
        parts: rows of ``RECORDINGS``, each part of whole recordings.
        record: what was read and what was refused.
        doubts: what is doubtful about them, one sentence each.
    """

    parts: list[pd.DataFrame]
    record: SourceRecord
    doubts: tuple[str, ...]

    @cached_property
    def noise(self) -> float:
        """Standard deviation of a coordinate, m."""
        groups = (part.groupby("recording_id")[POSITION_COLUMNS] for part in self.parts)
        return coordinate_noise([rows.to_numpy() for group in groups for _, rows in group])

    def episodes(self) -> list[MeasuredEpisode]:
        """Cut the recordings into episodes."""
        manifest = Manifest(sources={self.record.name: self.record})
        settings = SegmentSettings(noise=self.noise)
        cut = [
            segment_recordings(part, manifest.starts_with_launch, settings) for part in self.parts
        ]
        contacts = pd.concat([part.contacts for part in cut], ignore_index=True)
        episodes = pd.concat([part.episodes for part in cut], ignore_index=True)
        # No episode is reserved for another purpose here.
        episodes = episodes.assign(split="test", replay_set="none")
        return episodes_of(
            [part.samples for part in cut],
            checked(contacts, CONTACTS),
            checked(episodes, EPISODES),
            manifest.labelled_once,
        )


class _FolderContext(SourceContext):
    """The context of a source whose files are in this folder."""

    def __init__(self, folder: Path) -> None:
        super().__init__(IngestSettings.model_construct(folder=folder), seed=0)

    def folder(self, name: str) -> Path:
        return Path(str(self.settings.folder))


def read_recordings(folder: Path, source: str) -> Recordings:
    """Read the recordings of a folder.

    Args:
        folder: with the files of the source.
        source: name of the adapter that reads them.

    Raises:
        InputError: there is no such folder or source, a file is not what the source reads, or
            there are launches without a path.
    """
    known = {key: adapter for key, adapter in registry().items() if key != SIMULATED}
    if source not in known:
        problem = f"there is no source {source!r} of measured balls; {suggestion(source, known)}"
        raise InputError("--source", problem)
    if not folder.is_dir():
        raise InputError(folder, f"is not a folder; give the one with the files of {source}")
    data = known[source].read(_FolderContext(folder))
    imported = SourceImport(data)
    if imported.is_launches:
        raise InputError(folder, f"{source} has launches without a path; give recordings")
    tables = list(data.tables)
    doubts = check_recordings(tables, data.description.frame, data.conversion, folder)
    parts = [checked(imported.rows(batch), RECORDINGS) for batch in in_batches(tables)]
    return Recordings(parts, imported.record(), doubts)


def read_shots(folder: Path | str, source: str) -> MeasuredShots:
    """Read the recordings of a folder and cut them into shots.

    Args:
        folder: with the files of the source.
        source: name of the adapter that reads them.

    Raises:
        InputError: as ``read_recordings`` does.
    """
    recordings = read_recordings(Path(folder), source)
    episodes, record = recordings.episodes(), recordings.record
    chosen = source_shots(episodes)
    return MeasuredShots(
        name=record.name,
        shots=shots_of(chosen.members),
        nets=chosen.nets,
        recordings=record.recordings,
        refused=record.refused_counts,
        episodes=len(episodes),
        left_out=chosen.left_out,
        labels=_label_counts(recordings, chosen.members),
        bounces=sum(bool(member.episode.arc.any()) for member in chosen.members),
        noise=recordings.noise,
        doubts=recordings.doubts,
    )


def _label_counts(recordings: Recordings, chosen: Sequence[MeasuredEpisode]) -> LabelCounts:
    """Count the labels of recordings, of which some shots are chosen."""
    record = recordings.record
    kept = pd.concat(
        part["recording_id"][part[SPIN_COLUMNS].notna().all(axis=1)] for part in recordings.parts
    )
    labels = [np.isfinite(member.episode.spins).all(axis=1).sum() for member in chosen]
    used = pd.Series(np.repeat([member.recording_id for member in chosen], labels), dtype="str")
    if record.spin == "per_recording":
        kept, used = kept.drop_duplicates(), used.drop_duplicates()
    implausible = sum(refused.count for refused in record.labels_refused.values())
    return LabelCounts(len(kept) + implausible, implausible, len(used))
