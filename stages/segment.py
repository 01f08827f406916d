"""Cut recordings into episodes: contacts, gaps, ends of rallies, velocities; share them out."""

from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd

from models.segmentation.settings import SegmentSettings
from models.segmentation.split import recording_groups, split
from models.segmentation.tables import Segmented, segment_recordings
from pipeline.io.artifacts import (
    count_row_groups,
    read_row_group,
    read_row_groups,
    table_writer,
    write_table,
)
from pipeline.io.schemas import (
    CONTACTS,
    EPISODES,
    RECORDINGS,
    SAMPLES,
    check_columns,
    checked,
    empty,
)
from pipeline.runtime.console import warn
from pipeline.runtime.errors import InputError
from pipeline.runtime.parallel import parallel
from pipeline.runtime.progress import progress_bar
from pipeline.runtime.stage_run import StageRun, run_stage
from pipeline.segmentation.figures.cuts import SHOWN_SECONDS, cuts_figure
from pipeline.sources.manifest import Manifest, read_manifest

DRAWN_RECORDINGS = 20  # of each source


def segment(run: StageRun) -> None:
    """Cut every recording, share the recordings out, and say for each source how it went."""
    settings = run.params.segment
    manifest = read_manifest(run.input("ingest", "manifest.json"))
    drawn = _drawn(run)
    measured, shown, gaps = _cut(run, manifest, drawn)
    shares = split(shown.episodes, shown.contacts, settings.split, run.seed)
    for shortage in shares.shortages:
        warn(shortage)
    episodes = shown.episodes.assign(split=shares.split, replay_set=shares.replay_set)
    write_table(run.artifact("contacts.parquet"), checked(shown.contacts, CONTACTS))
    write_table(run.artifact("episodes.parquet"), checked(episodes, EPISODES))
    found = Segmented(shown.samples, shown.contacts, episodes)
    metrics = {}
    for source, chosen in drawn.items():
        metrics[source] = _metrics(manifest, source, found, gaps, settings)
        _draw(run, source, chosen, measured, found)
    run.write_metrics(metrics)
    _report_splits(run, episodes)


def _drawn(run: StageRun) -> dict[str, list[str]]:
    """Draw the recordings to show, by source, each of its groups in turn."""
    path = run.input("ingest", "recordings.parquet")
    check_columns(path, RECORDINGS)
    rows = [part["recording_id"].value_counts() for part in read_row_groups(path)]
    if not sum(map(len, rows)):
        raise InputError(path, "holds no recording; add a source that has some to ingest.sources")
    run.log_input("recordings", path, int(pd.concat(rows).sum()))
    ids = pd.concat(rows).sort_index().index.to_series()
    ids = ids.sample(frac=1, random_state=np.random.default_rng(run.seed))
    turns = ids.groupby(recording_groups(ids)).cumcount().sort_values(kind="stable")
    ids = ids.loc[turns.index]
    return {
        str(source): sorted(members[:DRAWN_RECORDINGS])
        for source, members in ids.groupby(ids.str.partition("/")[0], sort=True)
    }


@dataclass(frozen=True)
class Part:
    """A part of the recordings, in memory on its own: a row group of their table."""

    path: Path
    number: int
    manifest: Manifest
    settings: SegmentSettings
    shown: list[str]

    def cut(self) -> tuple[Segmented, pd.DataFrame, "pd.Series[str]"]:
        """Return what it is cut into, the measured samples to show, the recording of every gap."""
        recordings = checked(read_row_group(self.path, self.number), RECORDINGS, self.path)
        found = segment_recordings(recordings, self.manifest.begins_with_launch, self.settings)
        checked(found.samples, SAMPLES)
        measured = recordings[recordings["recording_id"].isin(self.shown)]
        return found, measured, _gaps(recordings, self.settings.longest_gap)


def _cut(
    run: StageRun, manifest: Manifest, drawn: dict[str, list[str]]
) -> tuple[pd.DataFrame, Segmented, "pd.Series[str]"]:
    """Cut the parts of the recordings side by side, and write their samples.

    Returns:
        The measured samples to show; all contacts and episodes, with the cut samples to show; and
        the recording of every gap.
    """
    path = run.input("ingest", "recordings.parquet")
    shown = [recording_id for chosen in drawn.values() for recording_id in chosen]
    parts = [
        Part(path, number, manifest, run.params.segment, shown)
        for number in range(count_row_groups(path))
    ]
    measured, tables, gaps = [], [], []
    with (
        table_writer(run.artifact("samples.parquet"), empty(SAMPLES)) as add,
        progress_bar("parts of the recordings", len(parts)) as advance,
    ):
        for found, seen, broken in parallel([part.cut for part in parts]):
            add(found.samples)
            samples = found.samples[found.samples["recording_id"].isin(shown)]
            tables.append((samples, found.contacts, found.episodes))
            measured.append(seen)
            gaps.append(broken)
            advance()
    joined = (pd.concat(kind, ignore_index=True) for kind in zip(*tables, strict=True))
    return pd.concat(measured), Segmented(*joined), pd.concat(gaps)


def _gaps(recordings: pd.DataFrame, longest: float) -> "pd.Series[str]":
    ids = recordings["recording_id"]
    return ids[(recordings["t"].diff() > longest) & (ids == ids.shift())]


def _metrics(
    manifest: Manifest,
    source: str,
    found: Segmented,
    gaps: "pd.Series[str]",
    settings: SegmentSettings,
) -> dict[str, Any]:
    record = manifest.sources[source]
    contacts = found.contacts[found.contacts["recording_id"].str.startswith(f"{source}/")]
    episodes = found.episodes[found.episodes["source"] == source]
    metrics: dict[str, Any] = {
        "recordings": record.recordings,
        "episodes": len(episodes),
        "contacts": contacts["kind"].value_counts().sort_index().to_dict(),
        "gaps": int(gaps.str.startswith(f"{source}/").sum()),
        "samples": record.rows_kept,
        "samples_in_episodes": int(episodes["samples"].sum()),
        "unbroken_residual_mm": round(1e3 * settings.unbroken_residual, 2),
    }
    if episodes.empty:
        return metrics
    return metrics | {
        "outlier_share": round(episodes["outliers"].sum() / episodes["samples"].sum(), 5),
        "median_residual_mm": round(1e3 * episodes["residual"].median(), 3),
        "unbroken_share": round(episodes["unbroken"].mean(), 4),
        "split": episodes["split"].value_counts().sort_index().to_dict(),
        "replay": episodes["replay_set"].value_counts().sort_index().drop("none").to_dict(),
    }


def _draw(
    run: StageRun, source: str, chosen: list[str], measured: pd.DataFrame, found: Segmented
) -> None:
    run.add_figure(
        cuts_figure(measured, found.samples, found.contacts, chosen),
        f"cuts_{source}",
        title=f"Cuts of {source}",
        caption=f"{len(chosen)} recordings, drawn by the seed: height above the table and place "
        f"along it, in the first {SHOWN_SECONDS:g} s. Lines are contacts.",
    )


def _report_splits(run: StageRun, episodes: pd.DataFrame) -> None:
    keys = [episodes["source"], recording_groups(episodes["recording_id"]).rename("group")]
    keys += [episodes["split"], episodes["replay_set"]]
    counts = episodes.groupby(keys)["recording_id"].agg(episodes="size", recordings="nunique")
    run.add_table(
        counts.reset_index(),
        "splits",
        title="Splits",
        caption="Episodes for training, validation, testing and replaying to a robot. A recording "
        "is in one split as a whole; of those to replay, not every episode is in a set.",
    )


if __name__ == "__main__":
    run_stage(segment)
