"""Report of the segmentation: metrics of each source, and the table of the splits."""

from typing import Any

import pandas as pd

from rallygap.models.segmentation.settings import SegmentSettings
from rallygap.models.segmentation.split import recording_groups
from rallygap.pipeline.io.report_items import ReportTable
from rallygap.pipeline.io.source_manifest import Manifest
from rallygap.pipeline.segmentation.cut_recordings import CutRecordings


def segmentation_metrics(
    manifest: Manifest,
    source: str,
    cut: CutRecordings,
    episodes: pd.DataFrame,
    settings: SegmentSettings,
) -> dict[str, Any]:
    """Return counts of a source's episodes, contacts and gaps, and how well paths fit.

    Args:
        manifest: of the sources.
        source: a name in the manifest.
        cut: all recordings.
        episodes: all episodes, with their splits.
        settings: of the segmentation.
    """
    record = manifest.sources[source]
    contacts = cut.segmented.contacts
    contacts = contacts[contacts["recording_id"].str.startswith(f"{source}/")]
    episodes = episodes[episodes["source"] == source]
    metrics: dict[str, Any] = {
        "recordings": record.recordings,
        "episodes": len(episodes),
        "contacts": contacts["kind"].value_counts().sort_index().to_dict(),
        "gaps": int(cut.gaps.str.startswith(f"{source}/").sum()),
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


def splits_table(episodes: pd.DataFrame) -> ReportTable:
    """Return the number of episodes and recordings of each source, group, split and replay set."""
    keys = [episodes["source"], recording_groups(episodes["recording_id"]).rename("group")]
    keys += [episodes["split"], episodes["replay_set"]]
    counts = episodes.groupby(keys)["recording_id"].agg(episodes="size", recordings="nunique")
    return ReportTable(
        counts.reset_index(),
        "splits",
        title="Splits",
        caption="Number of episodes and recordings in each split. A recording belongs to one "
        "split as a whole. Not every episode of a replay recording is in a replay set.",
    )
