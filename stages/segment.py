"""Cut recordings into episodes: contacts, gaps, ends of rallies, velocities."""

from typing import Any

import numpy as np
import pandas as pd

from models.segmentation.settings import SegmentSettings
from models.segmentation.tables import Segmented, segment_recordings
from pipeline.artifacts import read_table, write_table
from pipeline.contracts import CONTACTS, EPISODES, RECORDINGS, SAMPLES, checked
from pipeline.errors import InputError
from pipeline.figures.cuts import cuts_figure
from pipeline.run import StageRun, run_stage
from pipeline.sources.manifest import read_manifest

DRAWN_RECORDINGS = 20  # of each source


def segment(run: StageRun) -> None:
    """Cut every recording, and say for each source how it went."""
    recordings = _read_recordings(run)
    manifest = read_manifest(run.input("ingest", "manifest.json"))
    cannons = {name for name, source in manifest.sources.items() if source.kind == "cannon"}
    found = segment_recordings(recordings, cannons, run.params.segment)
    write_table(run.artifact("samples.parquet"), checked(found.samples, SAMPLES))
    write_table(run.artifact("contacts.parquet"), checked(found.contacts, CONTACTS))
    write_table(run.artifact("episodes.parquet"), checked(found.episodes, EPISODES))
    metrics: dict[str, Any] = {}
    for source in recordings["recording_id"].str.split("/").str[0].unique():
        measured, *tables = (
            table[table["recording_id"].str.startswith(f"{source}/")]
            for table in (recordings, found.samples, found.contacts, found.episodes)
        )
        metrics[source] = _metrics(measured, Segmented(*tables), run.params.segment)
        _draw(run, source, measured, Segmented(*tables))
    run.write_metrics(metrics)


def _read_recordings(run: StageRun) -> pd.DataFrame:
    path = run.input("ingest", "recordings.parquet")
    recordings = checked(read_table(path), RECORDINGS)
    if recordings.empty:
        raise InputError(path, "holds no recording; add a source that has some to ingest.sources")
    run.log_input("recordings", path, len(recordings))
    return recordings


def _metrics(measured: pd.DataFrame, found: Segmented, settings: SegmentSettings) -> dict[str, Any]:
    gaps = measured.groupby("recording_id")["t"].diff() > settings.longest_gap
    metrics: dict[str, Any] = {
        "recordings": measured["recording_id"].nunique(),
        "episodes": len(found.episodes),
        "contacts": found.contacts["kind"].value_counts().sort_index().to_dict(),
        "gaps": int(gaps.sum()),
        "samples": len(measured),
        "samples_in_episodes": len(found.samples),
        "unbroken_residual_mm": round(1e3 * settings.unbroken_residual, 2),
    }
    if found.episodes.empty:
        return metrics
    return metrics | {
        "outlier_share": round(found.samples["outlier"].mean(), 5),
        "median_residual_mm": round(1e3 * found.episodes["residual"].median(), 3),
        "unbroken_share": round(found.episodes["unbroken"].mean(), 4),
    }


def _draw(run: StageRun, source: str, measured: pd.DataFrame, found: Segmented) -> None:
    ids = measured["recording_id"].unique()
    number = min(DRAWN_RECORDINGS, len(ids))
    drawn = sorted(np.random.default_rng(run.seed).choice(ids, number, replace=False))
    run.add_figure(
        cuts_figure(measured, found.samples, found.contacts, drawn),
        f"cuts_{source}",
        title=f"Cuts of {source}",
        caption=f"{number} recordings of {len(ids)}, drawn by the seed: height above the table and "
        "place along it, against seconds since the recording began. Lines are contacts.",
    )


if __name__ == "__main__":
    run_stage(segment)
