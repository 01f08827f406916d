"""Cut recordings into episodes: contacts, gaps, ends of rallies, velocities; split them."""

import pandas as pd

from rallygap.models.segmentation.settings import SegmentSettings
from rallygap.pipeline.io.source_manifest import SourceRecord, read_manifest
from rallygap.pipeline.runtime.console import warn
from rallygap.pipeline.runtime.stage_run import StageRun, run_stage
from rallygap.pipeline.segmentation.cut_recordings import (
    CutRecordings,
    count_samples,
    draw_recordings,
)
from rallygap.pipeline.segmentation.episode_tables import write_episodes


def segment(run: StageRun) -> None:
    """Cut every recording, assign the recordings to splits, and report on each source."""
    settings = run.params.segment
    manifest = read_manifest(run.input("ingest", "manifest.json"))
    recordings = run.input("ingest", "recordings.parquet")
    counts = count_samples(recordings)
    run.log_input("recordings", recordings, int(counts.sum()))
    drawn = draw_recordings(counts, run.seed)

    ids = [recording_id for chosen in drawn.values() for recording_id in chosen]
    cut, episodes, shortages = write_episodes(run.root / "artifacts", settings, run.seed, ids)
    for shortage in shortages:
        warn(shortage)

    run.write_metrics(
        {source: _metrics(manifest.sources[source], cut, episodes, settings) for source in drawn}
    )
    contacts = cut.segmented.contacts
    run.keep(
        drawn_recordings=cut.measured,
        drawn_samples=cut.segmented.samples,
        drawn_contacts=contacts[contacts["recording_id"].isin(ids)],
    )


def _metrics(
    record: SourceRecord, cut: CutRecordings, episodes: pd.DataFrame, settings: SegmentSettings
) -> dict[str, float]:
    """Return counts of a source's episodes, contacts and gaps, and how well paths fit."""
    prefix = f"{record.name}/"
    contacts = cut.segmented.contacts
    contacts = contacts[contacts["recording_id"].str.startswith(prefix)]
    episodes = episodes[episodes["source"] == record.name]
    metrics = {
        "recordings": record.recordings,
        "episodes": len(episodes),
        "contacts": len(contacts),
        "gaps": int(cut.gaps.str.startswith(prefix).sum()),
        "samples_in_episodes": int(episodes["samples"].sum()),
        "unbroken_residual_mm": round(1e3 * settings.unbroken_residual, 2),
    }
    if episodes.empty:
        return metrics
    return metrics | {
        "outlier_share": round(episodes["outliers"].sum() / episodes["samples"].sum(), 5),
        "median_residual_mm": round(1e3 * episodes["residual"].median(), 3),
        "unbroken_share": round(episodes["unbroken"].mean(), 4),
    }


if __name__ == "__main__":
    run_stage(segment)
