"""From the tables of recordings to those of episodes, with their splits."""

from collections.abc import Sequence
from pathlib import Path
from typing import NamedTuple

import pandas as pd

from rallygap.models.segmentation.settings import SegmentSettings
from rallygap.models.segmentation.split import split
from rallygap.pipeline.io.artifacts import write_table
from rallygap.pipeline.io.schemas import CONTACTS, EPISODES, checked
from rallygap.pipeline.io.source_manifest import read_manifest
from rallygap.pipeline.segmentation.cut_recordings import CutRecordings, cut_recordings


class EpisodeTables(NamedTuple):
    """What recordings are cut into.

    Attributes:
        cut: recordings, contacts and gaps.
        episodes: all of them, with their splits.
        shortages: sentences about splits that are smaller than asked for.
    """

    cut: CutRecordings
    episodes: pd.DataFrame
    shortages: Sequence[str]


def write_episodes(
    artifacts: Path, settings: SegmentSettings, seed: int, drawn: Sequence[str] = ()
) -> EpisodeTables:
    """Cut all recordings, assign them to splits, and write ``artifacts/segment``.

    Args:
        artifacts: the folder of all stages' artefacts, with those of ``ingest``.
        settings: of the segmentation.
        seed: of the splits.
        drawn: ids of the recordings whose samples are returned.

    Raises:
        InputError: the recordings are missing or break their data contract.
    """
    read, written = artifacts / "ingest", artifacts / "segment"
    manifest = read_manifest(read / "manifest.json")
    tables = read / "recordings.parquet", written / "samples.parquet"
    cut = cut_recordings(*tables, manifest, settings, drawn)
    contacts, episodes = cut.segmented.contacts, cut.segmented.episodes
    splits = split(episodes, contacts, settings.split, seed)
    episodes = episodes.assign(split=splits.split, replay_set=splits.replay_set)
    write_table(written / "contacts.parquet", checked(contacts, CONTACTS))
    write_table(written / "episodes.parquet", checked(episodes, EPISODES))
    return EpisodeTables(cut, episodes, splits.shortages)
