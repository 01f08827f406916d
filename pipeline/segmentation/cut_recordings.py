"""From the table of recordings, one row group at a time, to those of episodes and splits."""

from collections.abc import Sequence
from functools import partial
from pathlib import Path
from typing import NamedTuple

import numpy as np
import pandas as pd

from rallygap.models.segmentation.settings import SegmentSettings
from rallygap.models.segmentation.split import recording_groups, split
from rallygap.models.segmentation.tables import Segmented, segment_recordings
from rallygap.pipeline.io.artifacts import open_table, read_row_groups, table_writer, write_table
from rallygap.pipeline.io.schemas import (
    CONTACTS,
    EPISODES,
    RECORDINGS,
    SAMPLES,
    check_columns,
    checked,
    empty,
)
from rallygap.pipeline.io.source_manifest import Manifest, read_manifest
from rallygap.pipeline.runtime.errors import InputError
from rallygap.pipeline.runtime.parallel import parallel

DRAWN_RECORDINGS = 20  # of each source


class CutRecordings(NamedTuple):
    """Recordings and what they are cut into.

    Attributes:
        measured: samples of the recordings to draw, as measured.
        segmented: all contacts and episodes, and the samples of the recordings to draw.
    """

    measured: pd.DataFrame
    segmented: Segmented


class EpisodeTables(NamedTuple):
    """What recordings are cut into.

    Attributes:
        cut: recordings and contacts.
        episodes: all of them, with their splits.
        shortages: sentences about splits that are smaller than asked for.
    """

    cut: CutRecordings
    episodes: pd.DataFrame
    shortages: Sequence[str]


def count_samples(path: Path) -> "pd.Series[int]":
    """Return the number of samples of every recording, by id.

    Raises:
        InputError: the table is missing, or holds no recording.
    """
    check_columns(path, RECORDINGS)
    counts = [part["recording_id"].value_counts() for part in read_row_groups(path)]
    if not sum(map(len, counts)):
        raise InputError(path, "holds no recording; add a source that has some to ingest.sources")
    return pd.concat(counts).sort_index()


def draw_recordings(samples: "pd.Series[int]", seed: int) -> dict[str, list[str]]:
    """Draw up to ``DRAWN_RECORDINGS`` ids of each source at random, from its groups in turn.

    Args:
        samples: the number of samples of every recording, by id.
        seed: of the draw.
    """
    ids = samples.index.to_series()
    ids = ids.sample(frac=1, random_state=np.random.default_rng(seed))
    turns = ids.groupby(recording_groups(ids)).cumcount().sort_values(kind="stable")
    ids = ids.loc[turns.index]
    return {
        str(source): sorted(members[:DRAWN_RECORDINGS])
        for source, members in ids.groupby(ids.str.partition("/")[0], sort=True)
    }


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


def cut_recordings(
    recordings: Path,
    samples: Path,
    manifest: Manifest,
    settings: SegmentSettings,
    drawn: Sequence[str] = (),
) -> CutRecordings:
    """Cut all recordings in parallel, and write their samples.

    Args:
        recordings: the table of recordings.
        samples: the table of samples to write.
        manifest: of the sources; tells which recordings start with a launch.
        settings: of the segmentation.
        drawn: ids of the recordings whose samples are returned.

    Raises:
        InputError: the recordings break their data contract.
    """
    with open_table(recordings) as opened:
        numbers = range(opened.num_row_groups)
    tasks = [partial(_cut, recordings, number, manifest, settings, drawn) for number in numbers]
    measured, kept, contacts, episodes = [], [], [], []
    with table_writer(samples, empty(SAMPLES)) as write:
        for cut in parallel(tasks, "parts of the recordings"):
            table = cut.segmented.samples
            write(table)
            measured.append(cut.measured)
            kept.append(table[table["recording_id"].isin(drawn)])
            contacts.append(cut.segmented.contacts)
            episodes.append(cut.segmented.episodes)
    parts = (pd.concat(tables, ignore_index=True) for tables in (kept, contacts, episodes))
    return CutRecordings(pd.concat(measured), Segmented(*parts))


def _cut(
    path: Path, number: int, manifest: Manifest, settings: SegmentSettings, drawn: Sequence[str]
) -> CutRecordings:
    """Cut the recordings of a row group; ``segmented`` has all their samples."""
    with open_table(path) as opened:
        recordings = opened.read_row_group(number).to_pandas()
    recordings = checked(recordings, RECORDINGS, path)
    segmented = segment_recordings(recordings, manifest.starts_with_launch, settings)
    checked(segmented.samples, SAMPLES)
    return CutRecordings(recordings[recordings["recording_id"].isin(drawn)], segmented)
