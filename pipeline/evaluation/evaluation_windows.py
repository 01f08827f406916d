"""The test episodes of every set of measured balls, cut into windows."""

from dataclasses import dataclass
from pathlib import Path

import numpy as np

from rallygap.models.predictors.windows import Windows, concatenate_windows, cut_windows
from rallygap.pipeline.io.episodes import MeasuredEpisode, read_episodes
from rallygap.pipeline.io.source_manifest import SourceRecord, read_manifest
from rallygap.pipeline.runtime.console import warn
from rallygap.pipeline.runtime.errors import InputError

NO_WINDOW = "155 ms with samples at most 15 ms apart"


@dataclass(frozen=True)
class MeasuredSet:
    """The test windows of one source.

    Attributes:
        source: of the recordings.
        windows: B windows.
        recordings: (B,) the recording of each.
        episodes: that the windows are cut from.
    """

    source: SourceRecord
    windows: Windows
    recordings: np.ndarray
    episodes: list[MeasuredEpisode]

    @property
    def name(self) -> str:
        """The source's name."""
        return self.source.name


def read_test_sets(artifacts: Path, every: float) -> list[MeasuredSet]:
    """Cut the unbroken test episodes of every source into windows; warn about sources without one.

    Args:
        artifacts: the folder of all stages' artefacts.
        every: s between the starts of an episode's windows.

    Raises:
        InputError: an artefact is missing or invalid, or no source has a window.
    """
    sets = read_sets(artifacts, every, "test")
    if not sets:
        problem = (
            f"no unbroken test episode has a window to evaluate: {NO_WINDOW}; are its sources in "
            "seconds and metres?"
        )
        raise InputError(artifacts / "segment" / "episodes.parquet", problem)
    return sets


def read_sets(artifacts: Path, every: float, split: str) -> list[MeasuredSet]:
    """Cut the unbroken episodes of a split into windows, as ``read_test_sets`` does.

    Raises:
        InputError: an artefact is missing or invalid.
    """
    manifest = read_manifest(artifacts / "ingest" / "manifest.json")
    episodes = read_episodes(artifacts / "segment", manifest.labelled_once, splits=(split,))
    sets = []
    for name in sorted({episode.source for episode in episodes}):
        members = [episode for episode in episodes if episode.source == name and episode.unbroken]
        parts = [cut_windows(member.episode, every) for member in members]
        if not any(map(len, parts)):
            warn(f"{name} has no window to evaluate: {NO_WINDOW}")
            continue
        ids = np.array([member.recording_id for member in members])
        recordings = np.repeat(ids, [len(part) for part in parts])
        source, windows = manifest.sources[name], concatenate_windows(parts)
        sets.append(MeasuredSet(source, windows, recordings, members))
    return sets
